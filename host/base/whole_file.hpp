// SPDX-License-Identifier: GPL-3.0-or-later
// Files are read whole and appear whole: a reader never sees a half-written output.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/base/result.hpp"

namespace tetragauge {

Result<std::string> read_whole_file(const std::filesystem::path& path);

// The file that writing to `path` makes or replaces: symbolic links followed. An error when that is anything
// but a regular file, for renaming over a device, a pipe or a socket would take it away from everybody.
Result<std::filesystem::path> file_to_replace(const std::filesystem::path& path);

// Writes to a temporary file beside file_to_replace(path), flushes it to disk and renames it over that.
Status write_whole_file(const std::filesystem::path& path, std::string_view content);

// Lower-case hexadecimal SHA-256.
std::string sha256_hex(std::string_view content);

}  // namespace tetragauge
