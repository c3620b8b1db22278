// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/terminal_text.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "host/report/print_text.hpp"
#include "host/report/verdict_line.hpp"

namespace tetragauge {
namespace {

struct Word {
  const char *at_line_start, *at_line_end, *colour;
};
constexpr std::array kWords{Word{"PASS:", " pass", "32"}, Word{"FAIL:", " fail", "1;31"},
                            Word{"UNDECIDED:", " undecided", "33"},
                            Word{"NOT MEASURED:", " not_measured", "35"}};

std::string coloured(const std::string& text) {
  std::istringstream lines(text);
  std::string out;
  for (std::string line; std::getline(lines, line);) {
    for (const Word& word : kWords) {
      const std::string on = print("\033[%sm", word.colour), off = "\033[0m";
      if (line.starts_with(word.at_line_start)) {
        line = on + line + off;
      } else if (line.ends_with(word.at_line_end)) {
        line = line.substr(0, line.size() - std::strlen(word.at_line_end) + 1) + on + (word.at_line_end + 1) +
               off;
      }
    }
    out += line + "\n";
  }
  return out;
}

// On one line if the path leaves room: the sentence is cut short, the first line has it whole.
std::string last_line(const std::string& verdict, const std::string& page_path) {
  const std::string end = "; report: " + page_path;
  const size_t room = std::max<size_t>(30, end.size() < kColumns ? kColumns - end.size() : 0);
  if (verdict.size() <= room) return verdict + end + "\n";
  return verdict.substr(0, verdict.rfind(' ', room - 4)) + " ..." + end + "\n";
}

}  // namespace

std::string terminal_text(const Report& report, const std::string& page_path, bool colour) {
  const std::string all = std::filesystem::path(page_path).replace_filename("report.txt").string();
  const std::string text = summary_text(report) + "\n" +
                           wrapped("surface of each face, distances and angles: " + all) +
                           last_line(verdict_line(report), page_path);
  return colour ? coloured(text) : text;
}

bool wants_colour(int file_descriptor) {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value && *value;
  };
  const char* terminal = std::getenv("TERM");
  return ::isatty(file_descriptor) == 1 && !is_set("NO_COLOR") && terminal &&
         std::strcmp(terminal, "dumb") != 0;
}

}  // namespace tetragauge
