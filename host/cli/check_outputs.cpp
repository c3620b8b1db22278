// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/check_outputs.hpp"

#include <unistd.h>

#include <filesystem>

#include "host/base/whole_file.hpp"

namespace tetragauge::cli {
namespace {

namespace fs = std::filesystem;

// Also for files that do not exist yet.
bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code code;
  if (fs::equivalent(a, b, code)) return true;
  // Of a relative path of which nothing exists, weakly_canonical() makes no absolute one.
  return fs::weakly_canonical(fs::absolute(a, code), code) ==
         fs::weakly_canonical(fs::absolute(b, code), code);
}

Status check_can_write(const std::string& path) {
  const Result<fs::path> file = file_to_replace(path);
  if (!file) return usage_error(file.error().message);
  std::error_code code;
  const fs::path folder = fs::absolute(*file, code).parent_path();
  if (!fs::is_directory(folder, code)) {
    return usage_error("cannot write " + path + ": there is no folder " + folder.string() +
                       "; make it first");
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    return usage_error("cannot write " + path + ": no permission in " + folder.string());
  }
  return Done{};
}

}  // namespace

Status check_outputs(const Console& console, const std::vector<std::string>& outputs,
                     const std::vector<std::string>& inputs) {
  std::vector<std::string> all = outputs;
  if (!console.json.empty() && console.json != "-") all.push_back(console.json);
  for (size_t k = 0; k < all.size(); ++k) {
    for (const std::string& input : inputs) {
      if (!input.empty() && same_file(all[k], input)) {
        return usage_error("cannot write " + all[k] + ": it is the input " + input +
                           ", which would be lost; name another file");
      }
    }
    for (size_t other = 0; other < k; ++other) {
      if (same_file(all[k], all[other]))
        return usage_error("cannot write " + all[k] + " twice: --json and --out name the same file");
    }
    if (Status status = check_can_write(all[k]); !status) return status;
  }
  return Done{};
}

CLI::Validator not_empty() {
  return CLI::Validator(
      [](const std::string& name) { return name.empty() ? std::string("the name is empty") : std::string(); },
      "");
}

}  // namespace tetragauge::cli
