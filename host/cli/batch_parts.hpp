// SPDX-License-Identifier: GPL-3.0-or-later
// Which parts a batch measures, one after the other, and where each report goes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/base/result.hpp"

namespace tetragauge::cli {

struct BatchPart {
  std::string name;              // its serial; of an emulated one its model's file name
  std::filesystem::path model;   // of the part as really made; emulated ones only
  std::filesystem::path folder;  // of its report
};

// The models in a folder, by file name. Reports go to `out`/name without its ending; where two share that,
// with it.
Result<std::vector<BatchPart>> parts_in_folder(const std::filesystem::path& folder,
                                               const std::filesystem::path& out);

// Asks at a terminal to change the part, and for its serial; nothing: no part more. An empty answer is
// `number`. Reports that stand in `out` already are left: a part measured again gets a folder of its own.
std::optional<BatchPart> ask_for_part(int64_t number, const std::filesystem::path& out);

// Of a serial that somebody has typed.
BatchPart part_named(const std::string& serial, const std::filesystem::path& out);

}  // namespace tetragauge::cli
