// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/check_step_numbers.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <locale>
#include <sstream>

namespace tetragauge {
namespace {

// OpenCASCADE takes lengths from here on for infinite (Precision::Infinite, 2e100), and their squares
// overflow.
constexpr double kLargest = 1e100;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// What C and Fortran libraries print for values that are no numbers. STEP knows no bare word that is not the
// name of an entity before its parenthesis.
bool says_not_a_number(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(),
                 [](char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); });
  constexpr std::array kWords{"NAN", "SNAN", "QNAN", "NANQ", "NANS", "IND", "INF", "INFINITY"};
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

// Of text that starts with a digit. Values too small for a double are 0, as the stream reads them.
bool is_usable(const std::string& number) {
  std::istringstream stream(number);
  stream.imbue(std::locale::classic());
  double value = 0;
  stream >> value;
  return std::abs(value) < kLargest;  // the stream gives the largest double for what overflows
}

// The clear text structure of ISO 10303-21: strings, comments, enumerations (.T.), references (#12), words
// and numbers; all else is punctuation.
class Walk {
 public:
  explicit Walk(std::string_view content) : content_(content) {}

  // The first number that is none, or empty at the end of the file; line() is then its line.
  std::string first_unusable() {
    while (at_ < content_.size()) {
      const char c = content_[at_];
      if (c == '\'' || c == '"') {
        skip_past(content_.find(c, at_ + 1), 1);  // a doubled quote within is the end and a new beginning
      } else if (content_.substr(at_, 2) == "/*") {
        skip_past(content_.find("*/", at_ + 2), 2);
      } else if (c == '#') {
        const size_t begin = at_++;
        take([](char d) { return is_digit(d) || is_letter(d); });
        // "1.#INF" and "1.#IND" are what older Microsoft libraries print.
        if (begin + 1 < at_ && is_letter(content_[begin + 1]) && begin > 0 && content_[begin - 1] == '.')
          return "#" + std::string(content_.substr(begin + 1, at_ - begin - 1));
      } else if (c == '.') {
        ++at_;
        take([](char d) { return is_digit(d) || is_letter(d); });
        if (at_ < content_.size() && content_[at_] == '.') ++at_;
      } else if (is_letter(c)) {
        const std::string word(take([](char d) { return is_digit(d) || is_letter(d) || d == '-'; }));
        if (next_is_not_list() && says_not_a_number(word)) return word;
      } else if (is_digit(c)) {
        const std::string number(take_number());
        if (!is_usable(number)) return number;
      } else {
        line_ += c == '\n';
        ++at_;
      }
    }
    return {};
  }

  size_t line() const { return line_; }

 private:
  void skip_past(size_t end, size_t length) {
    const size_t after = end == std::string_view::npos ? content_.size() : end + length;
    line_ += static_cast<size_t>(std::count(content_.begin() + static_cast<long>(at_),
                                            content_.begin() + static_cast<long>(after), '\n'));
    at_ = after;
  }

  template <typename Belongs>
  std::string_view take(Belongs belongs) {
    const size_t begin = at_;
    while (at_ < content_.size() && belongs(content_[at_])) ++at_;
    return content_.substr(begin, at_ - begin);
  }

  // Digits, point, digits, and an exponent if digits follow.
  std::string_view take_number() {
    const size_t begin = at_;
    take(is_digit);
    if (at_ < content_.size() && content_[at_] == '.') {
      ++at_;
      take(is_digit);
    }
    if (at_ < content_.size() && (content_[at_] == 'E' || content_[at_] == 'e')) {
      size_t digits = at_ + 1;
      if (digits < content_.size() && (content_[digits] == '+' || content_[digits] == '-')) ++digits;
      if (digits < content_.size() && is_digit(content_[digits])) {
        at_ = digits;
        take(is_digit);
      }
    }
    return content_.substr(begin, at_ - begin);
  }

  // An entity of that name would be followed by its list. "nan(ind)" is none: no list of STEP begins so.
  bool next_is_not_list() const {
    const size_t next = content_.find_first_not_of(" \t\r\n", at_);
    return next == std::string_view::npos || content_[next] != '(' ||
           (next + 1 < content_.size() && is_letter(content_[next + 1]));
  }

  std::string_view content_;
  size_t at_ = 0, line_ = 1;
};

}  // namespace

Status check_step_numbers(std::string_view content, const std::string& file) {
  Walk walk(content);
  const std::string number = walk.first_unusable();
  if (number.empty()) return Done{};
  return bad_input(file + ":" + std::to_string(walk.line()) + ": '" + number +
                   "' is not a number a part can have; export the part again, or correct that line");
}

}  // namespace tetragauge
