// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/check_error.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace tetragauge::fuzz {
namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("tetragauge_fuzz_" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// What a message may quote of a file is a few words.
constexpr size_t kLongestMessage = 700;

}  // namespace

void must(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

fs::path input_file(std::string_view content, const char* ending) {
  static const Folder folder;
  const fs::path path = folder.path() / (std::string("input") + ending);
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  must(file.flush().good(), "the input can be written as a file");
  return path;
}

void check_error(const Error& error, std::string_view name) {
  const std::string& message = error.message;
  const bool is_plain = std::all_of(message.begin(), message.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 32 && static_cast<unsigned char>(c) < 127;
  });
  if (!is_plain || message.size() > kLongestMessage || message.find(name) == std::string::npos)
    std::fprintf(stderr, "%.*s\n", 2000, message.c_str());
  must(is_plain, "a message is one line of plain text");
  must(message.size() <= kLongestMessage, "a message does not quote the whole file");
  must(message.find(name) != std::string::npos, "a message names the file");
}

}  // namespace tetragauge::fuzz
