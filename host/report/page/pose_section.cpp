// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/html_number.hpp"
#include "host/report/page/html_text.hpp"
#include "host/report/page/page_sections.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

std::string held_by(const ordered_json& alignment) {
  if (const std::string problem = alignment["problem"]; !problem.empty())
    return "Held by best fit, <strong>not by the datums asked for</strong>: " + html_text(problem) + ".";
  if (alignment["datums"].empty()) return "Held by best fit to all faces in place (no datums).";
  std::string out;
  for (const ordered_json& held : alignment["datums"]) {
    out += (out.empty() ? "Held by datum " : ", then ") + html_text(std::string(held["datum"])) +
           print(" (<a href=\"#face-%d\">face %d</a>: %d of 3 rotations, %d of 3 translations)",
                 held["face"].get<int>(), held["face"].get<int>(), held["rotations"].get<int>(),
                 held["translations"].get<int>());
  }
  return out + ".";
}

std::string vector_text(const ordered_json& v, int decimals, const char* unit) {
  return "(" + html_number(v[0], decimals) + ", " + html_number(v[1], decimals) + ", " +
         html_number(v[2], decimals) + ")" + unit;
}

std::string found_by(const ordered_json& json) {
  if (json["found_by"] == "surface") {
    const ordered_json& fit = json["surface_fit"];
    return "Found by all points against the model's whole surface, since " +
           html_text(std::string(fit["why"])) + ": " + html_number(100 * fit["explained"].get<double>(), 1) +
           " % of the points lie on it, scatter " + html_number(fit["scatter_mm"], 4) + " mm.";
  }
  return "Found by its planes: rms " + html_number(json["pose"]["rms_mm"], 4) + " mm over " +
         html_number(json["pairs"].size(), 0) + " paired faces.";
}

}  // namespace

std::string pose_section(const ordered_json& json) {
  const ordered_json &pose = json["pose"], &turn = json["rotation_deg"];
  std::string out = "<section id=\"pose\"><h2>Pose</h2>\n<p>" + held_by(json["alignment"]) + "</p>\n";
  out += "<p>Model from part: R<sub>z</sub>(" + html_number(turn["z"], 4) + "°) R<sub>y</sub>(" +
         html_number(turn["y"], 4) + "°) R<sub>x</sub>(" + html_number(turn["x"], 4) +
         "°), t = " + vector_text(pose["translation_mm"], 4, " mm") + ". " + found_by(json) + "</p>\n";
  for (const ordered_json& free : json["undetermined"]) {
    const bool shift = free["kind"] == "translation";
    out += std::string("<p class=\"warning\">Undetermined: ") +
           (shift ? "translation along " : "rotation about the axis ") + vector_text(free["axis"], 3, "") +
           (shift ? "" : " through " + vector_text(free["point_mm"], 2, " mm")) + ".</p>\n";
  }
  if (!json["equivalents"].empty()) {
    out +=
        "<h3>Equivalent poses</h3><p>The data cannot tell these from the one chosen.</p>\n<ol "
        "class=\"equivalents\">\n";
    size_t index = 0;
    for (const ordered_json& other : json["equivalents"])
      out +=
          print("<li data-equivalent=\"%zu\">", index++) + html_text(std::string(other["why"])) + "</li>\n";
    out += "</ol>\n";
  }
  if (!json["ruled_out"].empty()) {
    out += "<details><summary>Near-symmetric poses that were ruled out</summary><ul>\n";
    for (const ordered_json& other : json["ruled_out"])
      out += "<li>" + html_text(std::string(other["why"])) + "</li>\n";
    out += "</ul></details>\n";
  }
  return out + "</section>\n";
}

}  // namespace tetragauge
