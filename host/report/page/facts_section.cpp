// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/html_number.hpp"
#include "host/report/page/html_text.hpp"
#include "host/report/page/page_sections.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

// A name as it is, a number to six digits, a file with its hash, a list with its entries.
std::string value_html(const ordered_json& value) {
  if (value.is_string()) return html_text(value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) return print("%.6g", value.get<double>());
  if (value.is_object() && value.contains("sha256"))
    return html_text(value.value("name", std::string())) + " <span class=\"hash\">sha256&nbsp;" +
           html_text(value.value("sha256", std::string())) + "</span>";
  if (!value.is_array()) return html_text(value.dump());
  std::string out;
  for (const ordered_json& entry : value) out += (out.empty() ? "" : ", ") + value_html(entry);
  return "(" + out + ")";
}

// Key "u_cal_mm" as "u cal, mm".
std::string label(std::string key) {
  for (const char* unit : {"_mm3", "_mm2", "_mm5", "_mm", "_mrad", "_deg", "_s"}) {
    const std::string end = unit;
    if (key.size() > end.size() && key.ends_with(end)) {
      key = key.substr(0, key.size() - end.size()) + ", " + end.substr(1);
      break;
    }
  }
  for (char& c : key)
    if (c == '_') c = ' ';
  return key;
}

std::string facts(const ordered_json& block) {
  std::string out = "<dl>";
  for (const auto& [key, value] : block.items()) {
    const bool is_empty = value.is_null() || (value.is_string() && value.get<std::string>().empty());
    if (!is_empty)
      out += "<div><dt>" + html_text(label(key)) + "</dt><dd>" + value_html(value) + "</dd></div>\n";
  }
  return out + "</dl>\n";
}

}  // namespace

std::string facts_section(const ordered_json& json) {
  std::string out = "<section id=\"facts\"><h2>Run</h2>\n<h3>Input</h3>\n" + facts(json["input"]);
  ordered_json judged{{"rule", json["rule"]},
                      {"points_on_faces_used", json["points_on_faces"]["used"]},
                      {"points_rejected", json["points_on_faces"]["rejected"]},
                      {"smallest_feature_mm", html_number(json["smallest_feature_mm"], 1)}};
  out += "<h3>Inspection</h3>\n" + facts(judged);
  out += "<h3>Reconstruction</h3>\n" + facts(json["reconstruction"]);
  for (size_t k = 0; k < json["further_set_ups"].size(); ++k) {
    const ordered_json& set_up = json["further_set_ups"][k];
    out += print("<h3>Scan %zu</h3>\n", k + 2) + facts({{"scan", set_up["scan"]}}) +
           facts(set_up["reconstruction"]);
  }
  return out + "</section>\n";
}

}  // namespace tetragauge
