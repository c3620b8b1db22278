// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/html_number.hpp"

#include "host/report/print_text.hpp"

namespace tetragauge {

using nlohmann::ordered_json;

std::string html_number(const ordered_json& value, int decimals, bool with_sign) {
  if (!value.is_number()) return "–";
  std::string text = print("%.*f", decimals, value.get<double>());
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  if (text[0] == '-') text.erase(0, 1), text.insert(0, is_zero ? "" : "−");
  if (with_sign && !is_zero && value.get<double>() > 0) text.insert(0, "+");
  return text;
}

ordered_json at_path(const ordered_json& json, std::initializer_list<const char*> keys) {
  const ordered_json* at = &json;
  for (const char* key : keys) {
    if (!at->is_object() || !at->contains(key)) return nullptr;
    at = &(*at)[key];
  }
  return *at;
}

}  // namespace tetragauge
