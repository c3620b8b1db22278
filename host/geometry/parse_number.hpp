// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers in text files: independent of the locale, finite, the whole word.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace tetragauge {

template <class Number>
std::optional<Number> parse_number(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  Number value{};
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

// Takes the next word off `line` (separators: blank, tab, comma, semicolon, carriage return); empty at the
// end.
inline std::string_view next_word(std::string_view& line) {
  constexpr std::string_view separators = " \t,;\r";
  const size_t start = line.find_first_not_of(separators);
  if (start == std::string_view::npos) {
    line = {};
    return {};
  }
  const size_t stop = std::min(line.find_first_of(separators, start), line.size());
  const std::string_view word = line.substr(start, stop - start);
  line.remove_prefix(stop);
  return word;
}

// Takes the next line off `text`, without its end.
inline std::string_view next_line(std::string_view& text) {
  const size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

}  // namespace tetragauge
