// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/parse_csg.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "host/base/excerpt.hpp"

namespace tetragauge {
namespace {

struct SyntaxFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Recursive descent goes as deep as the braces; a damaged file must not exhaust the stack.
constexpr int kDeepest = 1000;

class Parser {
 public:
  Parser(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  std::vector<CsgNode> parse() {
    std::vector<CsgNode> nodes = parse_nodes(0);
    if (at_ < text_.size()) fail("'}' without its '{'");
    return nodes;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw SyntaxFailure(file_ + ":" + std::to_string(line_) + ": " + what +
                        "; expected .csg text as OpenSCAD exports it");
  }

  void skip_space() {
    while (at_ < text_.size()) {
      if (text_[at_] == '\n') {
        ++line_;
        ++at_;
      } else if (std::isspace(static_cast<unsigned char>(text_[at_]))) {
        ++at_;
      } else if (text_.substr(at_, 2) == "//") {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (text_.substr(at_, 2) == "/*") {
        const size_t end = text_.find("*/", at_ + 2);
        if (end == std::string_view::npos) fail("comment without its end");
        for (; at_ < end + 2; ++at_) line_ += text_[at_] == '\n';
      } else {
        return;
      }
    }
  }

  bool accept(char c) {
    skip_space();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  void expect(char c) {
    if (accept(c)) return;
    if (at_ >= text_.size()) fail(std::string("the file ends where '") + c + "' should stand");
    fail("'" + excerpt(text_.substr(at_, 1)) + "' where '" + c + "' should stand");
  }

  static bool is_name_character(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '$';
  }

  std::string parse_name() {
    skip_space();
    const size_t begin = at_;
    while (at_ < text_.size() && is_name_character(text_[at_])) ++at_;
    if (at_ == begin) {
      if (at_ >= text_.size()) fail("the file ends where a name should stand");
      fail("'" + excerpt(text_.substr(at_, 1)) + "' where a name should stand");
    }
    return std::string(text_.substr(begin, at_ - begin));
  }

  CsgValue parse_value(int depth) {
    if (depth > kDeepest) fail("lists nested too deeply");
    skip_space();
    if (at_ >= text_.size()) fail("the file ends where a value should stand");
    const char c = text_[at_];
    if (c == '[') return parse_list(depth);
    if (c == '"') return parse_string();
    if (std::isalpha(static_cast<unsigned char>(c))) {
      const std::string word = parse_name();
      if (word == "true") return {true};
      if (word == "false") return {false};
      if (word == "undef") return {CsgUndef{}};
      fail("'" + excerpt(word) + "' is not a value");
    }
    return parse_number();
  }

  CsgValue parse_list(int depth) {
    expect('[');
    CsgList list;
    if (accept(']')) return {std::move(list)};
    do {
      list.push_back(parse_value(depth + 1));
    } while (accept(','));
    expect(']');
    return {std::move(list)};
  }

  CsgValue parse_string() {
    std::string value;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
      line_ += text_[at_] == '\n';
      value += text_[at_];
    }
    if (at_ >= text_.size()) fail("string without its end");
    ++at_;
    return {std::move(value)};
  }

  CsgValue parse_number() {
    double value = 0;
    const char* const begin = text_.data() + at_;
    const auto [end, code] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (code != std::errc{} || !std::isfinite(value)) {
      fail("no finite number at '" + excerpt(text_.substr(at_, 1)) + "'");
    }
    at_ += static_cast<size_t>(end - begin);
    return {value};
  }

  void parse_arguments(CsgNode& node) {
    expect('(');
    if (accept(')')) return;
    do {
      skip_space();
      std::string name;
      const size_t begin = at_;
      while (at_ < text_.size() && is_name_character(text_[at_])) ++at_;
      if (at_ > begin) name = text_.substr(begin, at_ - begin);
      if (name.empty() || !accept('=')) {
        at_ = begin;
        name.clear();
      }
      CsgValue value = parse_value(0);
      node.arguments.emplace_back(std::move(name), std::move(value));
    } while (accept(','));
    expect(')');
  }

  std::vector<CsgNode> parse_nodes(int depth) {
    if (depth > kDeepest) fail("calls nested too deeply");
    std::vector<CsgNode> nodes;
    for (;;) {
      skip_space();
      if (at_ >= text_.size() || text_[at_] == '}') return nodes;
      if (accept(';')) continue;
      bool left_out = false;
      while (at_ < text_.size() && (text_[at_] == '%' || text_[at_] == '*' || text_[at_] == '#')) {
        left_out |= text_[at_] != '#';
        ++at_;
        skip_space();
      }
      CsgNode node;
      skip_space();
      node.line = line_;
      node.name = parse_name();
      parse_arguments(node);
      if (!accept(';')) {
        expect('{');
        node.children = parse_nodes(depth + 1);
        expect('}');
      }
      if (!left_out) nodes.push_back(std::move(node));
    }
  }

  std::string_view text_;
  const std::string& file_;
  size_t at_ = 0;
  int line_ = 1;
};

}  // namespace

Result<std::vector<CsgNode>> parse_csg(std::string_view text, const std::string& file) {
  try {
    return Parser(text, file).parse();
  } catch (const SyntaxFailure& failure) {
    return bad_input(failure.what());
  }
}

}  // namespace tetragauge
