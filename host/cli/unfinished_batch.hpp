// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch of parts keeps beside their reports while it runs, so that one that was broken off can be gone
// on with: what it was begun with, and the parts that are finished.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "host/base/result.hpp"

namespace tetragauge::cli {

struct FinishedPart {
  int64_t number = 0;  // in the history
  int exit_code = 0;
};

class UnfinishedBatch {
 public:
  // In the folder of the batch's reports. `order`: what must be the same for one batch, by the name of the
  // option.
  static std::filesystem::path path_in(const std::filesystem::path& folder);
  static Result<UnfinishedBatch> begin(const std::filesystem::path& folder,
                                       const nlohmann::ordered_json& order);
  // Errors (bad input): there is none, or it was begun with something else.
  static Result<UnfinishedBatch> reopen(const std::filesystem::path& folder,
                                        const nlohmann::ordered_json& order);

  const std::map<std::string, FinishedPart>& finished() const { return finished_; }
  const std::string& broken_off() const { return begun_; }  // the part that was being measured; "": none
  // On the disk when they return.
  Status begin_part(const std::string& part);
  Status end_part(const std::string& part, const FinishedPart& finished);
  // All parts are finished.
  void remove() const;

 private:
  Status write() const;

  std::filesystem::path path_;
  nlohmann::ordered_json order_;
  std::string begun_;
  std::map<std::string, FinishedPart> finished_;
};

}  // namespace tetragauge::cli
