// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/html_number.hpp"
#include "host/report/page/html_text.hpp"
#include "host/report/page/page_sections.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

std::string place(const ordered_json& v) {
  return "(" + html_number(v[0], 1) + ", " + html_number(v[1], 1) + ", " + html_number(v[2], 1) + ") mm";
}

// What the script shows when the item is chosen: kind and place in its list of report.json.
std::string item(const char* kind, size_t index, const char* sign, const std::string& html) {
  return print(
             "<li data-finding=\"%s\" data-index=\"%zu\"><span class=\"sign %s\" "
             "aria-hidden=\"true\">%s</span> ",
             kind, index, kind, sign) +
         html + "</li>\n";
}

std::string face_link(const ordered_json& id) {
  return print("<a href=\"#face-%d\">face %d</a>", id.get<int>(), id.get<int>());
}

std::string face_links(const ordered_json& ids) {
  std::string out;
  for (const ordered_json& id : ids) out += (out.empty() ? "" : ", ") + face_link(id);
  return out;
}

}  // namespace

std::string findings_section(const ordered_json& json) {
  std::string items;
  size_t index = 0;
  for (const ordered_json& id : json["missing_faces"])
    items += item("missing", index++, "∅",
                  "Missing: " + face_link(id) + ". Rays went through where it should be.");
  index = 0;
  for (const ordered_json& feature : json["misplaced"]) {
    const ordered_json& shift = feature["shift_mm"];
    items += item("misplaced", index++, "↦",
                  "Misplaced: " + face_links(feature["faces"]) + " together, shifted by (" +
                      html_number(shift[0], 3, true) + ", " + html_number(shift[1], 3, true) + ", " +
                      html_number(shift[2], 3, true) + ") mm, turned by " +
                      html_number(feature["turn_deg"], 3) + "°.");
  }
  index = 0;
  for (const ordered_json& extra : json["extra_faces"]) {
    items +=
        item("extra", index++, "+",
             "Extra face, not of the model (" + html_text(std::string(extra["type"])) + ", " +
                 html_number(extra["area_mm2"], 1) + " mm²) at " + place(extra["point_mm"]) +
                 (extra["out_of_tolerance"].get<bool>() ? ", out of tolerance." : ", within tolerance."));
  }
  index = 0;
  for (const ordered_json& fault : json["material_faults"]) {
    const bool is_missing = fault["kind"] == "missing";
    const std::string depth = fault["depth_mm"].is_number() && fault["depth_mm"].get<double>() > 0
                                  ? ", " + html_number(fault["depth_mm"], 3) + " mm off the face"
                                  : std::string();
    items += item("material", index++, is_missing ? "⊖" : "⊕",
                  std::string(is_missing ? "Material missing on " : "Material in excess on ") +
                      face_link(fault["face"]) + " near " + place(fault["point_mm"]) + ": " +
                      html_number(fault["rays"], 0) +
                      (is_missing ? " rays went through" : " rays stopped short") + depth + ".");
  }
  std::string remarks;
  for (const ordered_json& face : json["faces"])
    if (const std::string reason = face.value("reason", std::string()); !reason.empty())
      remarks += "<li>" + face_link(face["id"]) + ": " + html_text(reason) + "</li>\n";
  if (items.empty() && remarks.empty()) return "";
  std::string out = "<section id=\"findings\"><h2>Findings</h2>\n";
  if (!items.empty()) out += "<ul class=\"findings\">\n" + items + "</ul>\n";
  if (!remarks.empty()) out += "<h3>Remarks on faces</h3>\n<ul>\n" + remarks + "</ul>\n";
  return out + "</section>\n";
}

}  // namespace tetragauge
