// SPDX-License-Identifier: GPL-3.0-or-later
// What the fuzzers of file readers have in common: the input as a file, and what every error must be like.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/base/result.hpp"

namespace tetragauge::fuzz {

// Ends the program, naming what does not hold.
void must(bool holds, const char* what);

// A file with that content, the same one for the same ending each time, removed when the program ends.
std::filesystem::path input_file(std::string_view content, const char* ending);

// The message begins with the file's name and is one line that a terminal shows as it is, not the file's
// bytes.
void check_error(const Error& error, std::string_view name);

}  // namespace tetragauge::fuzz
