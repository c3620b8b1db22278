// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "host/report/page/html_number.hpp"
#include "host/report/page/page_sections.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

constexpr size_t kMostRows = 100;  // of each table; report.json has them all

std::string table(const ordered_json& relations, bool parallel, const char* caption, const char* head,
                  const char* deviation, const char* U, std::string (*row)(const ordered_json&)) {
  std::vector<const ordered_json*> found;
  for (const ordered_json& relation : relations)
    if (relation["parallel"].get<bool>() == parallel) found.push_back(&relation);
  if (found.empty()) return "";
  const auto significance = [&](const ordered_json* r) {
    return std::abs((*r)[deviation].is_number() ? (*r)[deviation].get<double>() : 0.0) /
           std::max(1e-9, (*r)[U].is_number() ? (*r)[U].get<double>() : 0.0);
  };
  std::stable_sort(found.begin(), found.end(), [&](const ordered_json* a, const ordered_json* b) {
    return significance(a) > significance(b);
  });
  std::string out =
      print(
          "<details><summary>%s (%zu), farthest out first</summary><div class=\"scroll\"><table><thead><tr>",
          caption, found.size()) +
      head + "</tr></thead><tbody>\n";
  for (size_t k = 0; k < std::min(kMostRows, found.size()); ++k) {
    const ordered_json& r = *found[k];
    const int a = r["faces"][0], b = r["faces"][1];
    out += print("<tr><th scope=\"row\"><a href=\"#face-%d\">%d</a> and <a href=\"#face-%d\">%d</a></th>", a,
                 a, b, b);
    out += row(r) + "</tr>\n";
  }
  out += "</tbody></table></div>";
  if (found.size() > kMostRows)
    out += print("<p>The first %zu of %zu; all stand in report.json.</p>", kMostRows, found.size());
  return out + "</details>\n";
}

std::string cell(const ordered_json& value, int decimals, bool with_sign = false) {
  return "<td class=\"number\">" + html_number(value, decimals, with_sign) + "</td>";
}

}  // namespace

std::string relations_section(const ordered_json& json) {
  const std::string distances =
      table(json["relations"], true, "Distances of parallel faces",
            "<th>Faces</th><th>Distance mm</th><th>Nominal mm</th><th>Deviation mm</th><th>± U "
            "mm</th><th>Out of parallel "
            "mrad</th><th>± U mrad</th>",
            "distance_deviation_mm", "U_distance_mm", [](const ordered_json& r) {
              return cell(r["distance_mm"], 3) + cell(r["nominal_distance_mm"], 3) +
                     cell(r["distance_deviation_mm"], 3, true) + cell(r["U_distance_mm"], 3) +
                     cell(r["angle_deviation_mrad"], 2) + cell(r["U_angle_mrad"], 2);
            });
  const std::string angles =
      table(json["relations"], false, "Angles between neighbours' normals",
            "<th>Faces</th><th>Angle °</th><th>Nominal °</th><th>Deviation mrad</th><th>± U mrad</th>",
            "angle_deviation_mrad", "U_angle_mrad", [](const ordered_json& r) {
              return cell(r["angle_deg"], 4) + cell(r["nominal_angle_deg"], 4) +
                     cell(r["angle_deviation_mrad"], 3, true) + cell(r["U_angle_mrad"], 3);
            });
  if (distances.empty() && angles.empty()) return "";
  return "<section id=\"relations\"><h2>Faces to each other, whatever the pose</h2>\n" + distances + angles +
         "</section>\n";
}

}  // namespace tetragauge
