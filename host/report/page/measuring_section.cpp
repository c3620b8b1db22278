// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/html_number.hpp"
#include "host/report/page/html_text.hpp"
#include "host/report/page/page_sections.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

std::string cell(const std::string& text) {
  return "<td class=\"number\">" + text + "</td>";
}

std::string change(const ordered_json& round, const char* key, int decimals) {
  return cell(html_number(round["before"][key], decimals) + " → " +
              html_number(round["after"][key], decimals));
}

}  // namespace

std::string measuring_section(const ordered_json& json) {
  if (!json.contains("plan")) return "";
  std::string out =
      "<section id=\"measuring\"><h2>Measuring</h2>\n<p>Views: " + html_text(std::string(json["plan"])) +
      ".</p>\n";
  if (!json["rounds"].empty()) {
    out +=
        "<div class=\"scroll\"><table><caption>What each round of going back to what was in doubt "
        "changed.</caption><thead><tr><th scope=\"col\">Round</th>";
    for (const char* head : {"Directions", "Views", "Points", "Machine s", "In doubt mm³",
                             "Of it for a ray mm³", "Faces undecided", "Faces not measured"})
      out += std::string("<th scope=\"col\" class=\"number\">") + head + "</th>";
    out += "</tr></thead><tbody>\n";
    size_t count = 0;
    for (const ordered_json& round : json["rounds"]) {
      out += print("<tr><th scope=\"row\">%zu</th>", ++count) + cell(html_number(round["rays"], 0)) +
             cell(html_number(round["views"], 0)) + cell(html_number(round["points"], 0)) +
             cell(html_number(round["machine_s"], 0)) + change(round, "doubtful_mm3", 1) +
             change(round, "resolvable_mm3", 1) + change(round, "undecided", 0) +
             change(round, "not_measured", 0) + "</tr>\n";
    }
    out += "</tbody></table></div>\n";
  }
  if (const std::string end = json["rounds_end"]; !end.empty())
    out += "<p>Re-measuring ended: " + html_text(end) + ".</p>\n";
  return out + "</section>\n";
}

}  // namespace tetragauge
