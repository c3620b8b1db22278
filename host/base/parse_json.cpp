// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/parse_json.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <vector>

#include "host/base/excerpt.hpp"

namespace tetragauge {
namespace {

using nlohmann::json;

// No file of ours goes deeper than ten; printing or copying a value takes stack for every level.
constexpr int kDeepest = 64;

struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// "line:column: " of a byte, each from 1.
std::string place_of(std::string_view text, size_t byte) {
  const std::string_view before = text.substr(0, byte);
  const size_t line_start = before.rfind('\n') + 1;  // 0 when there is none
  return std::to_string(std::count(before.begin(), before.end(), '\n') + 1) + ":" +
         std::to_string(byte - line_start + 1) + ": ";
}

}  // namespace

Result<json> parse_json(std::string_view text, const std::string& name) {
  std::vector<std::set<std::string>> open_objects;
  const auto watch = [&](int depth, json::parse_event_t event, json& value) {
    if (depth > kDeepest) throw Refused("nested more than " + std::to_string(kDeepest) + " deep");
    if (event == json::parse_event_t::object_start) open_objects.emplace_back();
    if (event == json::parse_event_t::object_end) open_objects.pop_back();
    if (event == json::parse_event_t::key) {
      const std::string& key = value.get_ref<const std::string&>();
      if (!open_objects.back().insert(key).second)
        throw Refused("has the key \"" + excerpt(key) + "\" twice; keep one");
    }
    return true;
  };
  try {
    return json::parse(text, watch);
  } catch (const Refused& refused) {
    return bad_input(name + ": " + refused.what());
  } catch (const json::parse_error& error) {
    const size_t byte = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
    return bad_input(name + ":" + place_of(text, byte) + "not readable as JSON " +
                     (byte == text.size() ? "as it ends here: cut short, or a bracket is missing"
                                          : "at '" + excerpt(text.substr(byte)) + "'; repair it there"));
  } catch (const json::exception& error) {  // a number that no double holds
    const std::string_view what = error.what();
    return bad_input(name + ": not readable as JSON: " + excerpt(what.substr(what.find(']') + 2)) +
                     "; write a number within 1e308");
  }
}

}  // namespace tetragauge
