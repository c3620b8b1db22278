// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/batch_parts.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <map>
#include <string_view>

namespace tetragauge::cli {
namespace {

namespace fs = std::filesystem;

bool is_model(const fs::path& path) {
  constexpr std::array<std::string_view, 7> kEndings{".step", ".stp", ".csg", ".stl", ".obj", ".ply", ".off"};
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

// A serial may hold what a folder's name must not.
std::string folder_name(const std::string& serial) {
  std::string name = serial;
  for (char& c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                          c == '-' || c == '_' || c == '.';
    if (!is_plain) c = '_';
  }
  if (name.empty() || name.front() == '.') name.insert(0, "_");
  return name.substr(0, 100);
}

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

}  // namespace

Result<std::vector<BatchPart>> parts_in_folder(const fs::path& folder, const fs::path& out) {
  std::error_code code;
  std::vector<fs::path> files;
  for (fs::directory_iterator at(folder, code), end; !code && at != end; at.increment(code))
    if (at->is_regular_file(code) && is_model(at->path())) files.push_back(at->path());
  if (code) return bad_input(folder.string() + ": cannot list it: " + code.message());
  if (files.empty())
    return bad_input(folder.string() +
                     ": there is no model of a part in it (.step, .stp, .csg, .stl, .obj, .ply, .off)");
  // By the bytes of the name: the order in which a folder lists its files is nobody's choice.
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return a.filename().string() < b.filename().string();
  });
  std::map<std::string, int> stems;
  for (const fs::path& file : files) ++stems[file.stem().string()];
  std::vector<BatchPart> parts;
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    parts.push_back({name, file, out / (stems[file.stem().string()] > 1 ? name : file.stem().string())});
  }
  return parts;
}

BatchPart part_named(const std::string& serial, const fs::path& out) {
  const std::string name = folder_name(serial);
  fs::path folder = out / name;
  std::error_code ignored;
  for (int k = 2; fs::exists(folder, ignored); ++k) folder = out / (name + "-" + std::to_string(k));
  return {serial, {}, folder};
}

std::optional<BatchPart> ask_for_part(int64_t number, const fs::path& out) {
  std::fprintf(stderr,
               "\nput the next part on the table, then type its serial and Enter (Enter alone: %lld; q: no "
               "more): ",
               static_cast<long long>(number));
  std::string answer;
  if (!std::getline(std::cin, answer)) return std::nullopt;
  answer = trimmed(answer);
  if (answer == "q" || answer == "Q") return std::nullopt;
  return part_named(answer.empty() ? std::to_string(number) : answer, out);
}

}  // namespace tetragauge::cli
