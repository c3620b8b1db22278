// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/pair_rules_file.hpp"

#include <array>
#include <limits>
#include <string>
#include <string_view>

#include "host/base/nearest_name.hpp"
#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"

namespace tetragauge {
namespace {

constexpr std::array<std::string_view, 2> kKeys{"fix", "forbid"};

bool is_id(const nlohmann::json& value) {
  return value.is_number_integer() && value >= 1 && value <= std::numeric_limits<int>::max();
}

Result<std::vector<FaceIds>> read_pairs(const nlohmann::json& list, const std::string& place) {
  std::vector<FaceIds> pairs;
  if (!list.is_array()) return bad_input(place + ": expected a list of pairs [model, measured]");
  for (size_t k = 0; k < list.size(); ++k) {
    const nlohmann::json& pair = list[k];
    if (!pair.is_array() || pair.size() != 2 || !is_id(pair[0]) || !is_id(pair[1]))
      return bad_input(place + "[" + std::to_string(k) +
                       "]: expected two face ids (whole numbers from 1), [model, measured]");
    pairs.push_back({pair[0].get<int>(), pair[1].get<int>()});
  }
  return pairs;
}

}  // namespace

Result<PairRules> read_pair_rules(const std::filesystem::path& path) {
  const std::string name = path.string();
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  const Result<nlohmann::json> json = parse_json(*text, name);
  if (!json) return json.error();
  if (!json->is_object())
    return bad_input(name + ": expected {\"fix\": [[model, measured], ...], \"forbid\": [...]}");
  PairRules rules;
  rules.file = name;
  for (const auto& [key, value] : json->items()) {
    const std::string place = name + ": " + key;
    if (key != kKeys[0] && key != kKeys[1])
      return bad_input(place + " is no key of a file of pairs; did you mean " + nearest_name(key, kKeys) +
                       "?");
    Result<std::vector<FaceIds>> pairs = read_pairs(value, place);
    if (!pairs) return pairs.error();
    (key == kKeys[0] ? rules.fixed : rules.forbidden) = std::move(*pairs);
  }
  return rules;
}

}  // namespace tetragauge
