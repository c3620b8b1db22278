// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/parse_json.hpp"

#include <gtest/gtest.h>

#include "host/base/excerpt.hpp"

namespace tetragauge {
namespace {

std::string error_of(std::string_view text) {
  const Result<nlohmann::json> json = parse_json(text, "plan.json");
  return json ? "" : json.error().message;
}

TEST(ParseJson, reads_what_is_right) {
  const Result<nlohmann::json> json = parse_json(R"({"a": [1, {"b": 2}], "c": {"b": 3}})", "plan.json");
  ASSERT_TRUE(json.ok()) << json.error().message;
  EXPECT_EQ((*json)["a"][1]["b"], 2);
  EXPECT_EQ((*json)["c"]["b"], 3);
}

TEST(ParseJson, errors_name_the_place) {
  EXPECT_EQ(error_of("{\"a\": 1,\n \"b\": x}").rfind("plan.json:2:7: ", 0), 0u)
      << error_of("{\"a\": 1,\n \"b\": x}");
  EXPECT_EQ(error_of("{\"a\": [1,").rfind("plan.json:1:10: ", 0), 0u) << error_of("{\"a\": [1,");
  EXPECT_NE(error_of("{\"a\": [1,").find("cut short"), std::string::npos);
  EXPECT_NE(error_of("").find("cut short"), std::string::npos);
  EXPECT_NE(error_of("{\"a\": 1, \"a\": 2}").find("\"a\" twice"), std::string::npos);
  EXPECT_NE(error_of("[1e999]").find("1e999"), std::string::npos);
}

TEST(ParseJson, whatever_comes_in_the_error_is_short_and_plain) {
  for (const std::string& text : {std::string("\x7f"
                                              "ELF\0\1\2\xff",
                                              8),
                                  std::string(100'000, 'x'), "\"" + std::string(100'000, '\x80'),
                                  "{\"" + std::string(100'000, 'k') + "\n", std::string(100'000, '['),
                                  "[" + std::string(100'000, '9') + "]"}) {
    const std::string message = error_of(text);
    EXPECT_FALSE(message.empty());
    EXPECT_LT(message.size(), 200u);
    for (const char c : message) EXPECT_TRUE(c >= ' ' && c <= '~') << static_cast<int>(c);
  }
  // Deep enough to end the program that copies or prints it.
  EXPECT_NE(error_of(std::string(1'000'000, '[') + std::string(1'000'000, ']')).find("nested"),
            std::string::npos);
}

TEST(Excerpt, is_short_and_plain) {
  EXPECT_EQ(excerpt("word"), "word");
  EXPECT_EQ(excerpt("a\x1b[2Jb\n\xff"), "a?[2Jb??");
  EXPECT_EQ(excerpt(std::string(41, 'a')), std::string(40, 'a') + "...");
  EXPECT_EQ(excerpt(""), "");
}

}  // namespace
}  // namespace tetragauge
