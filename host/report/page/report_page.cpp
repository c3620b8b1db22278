// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/report_page.hpp"

#include "host/report/page/html_number.hpp"
#include "host/report/page/html_text.hpp"
#include "host/report/page/page_assets.hpp"
#include "host/report/page/page_data.hpp"
#include "host/report/page/page_sections.hpp"
#include "host/report/verdict_line.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

std::string file_name(const ordered_json& file) {
  if (!file.is_object()) return "";
  const std::string name = file.value("name", std::string());
  return name.substr(name.find_last_of('/') + 1);
}

// The terminal's +- as it is printed.
std::string typeset(std::string text) {
  for (size_t at = text.find("+-"); at != std::string::npos; at = text.find("+-", at))
    text.replace(at, 2, "±");
  return text;
}

// What stands under the verdict: which part, which files.
std::string summary(const ordered_json& json) {
  const ordered_json& input = json["input"];
  std::string out;
  const auto add = [&](const char* what, const std::string& value) {
    if (!value.empty()) out += std::string("<li>") + what + " <b>" + html_text(value) + "</b></li>";
  };
  add("Part", input["part_serial"]);
  add("Model", file_name(input["model"]));
  add("Scan", file_name(input["scan"]));
  add("Points", html_number(input["points"], 0));
  add("Tolerances", file_name(input["tolerances"]));
  add("Rule", json["rule"]);
  add("Machine", input["machine_id"]);
  return out;
}

std::string interruption(const ordered_json& json) {
  const std::string what = json.value("interruption", std::string());
  return what.empty() ? "" : "<p class=\"warning\">Re-measuring was broken off: " + html_text(what) + "</p>";
}

}  // namespace

std::string report_page(const Report& report) {
  ordered_json json = report_json(report);
  json.erase("timing_s");
  const std::string verdict = json["verdict"];
  const std::string line = typeset(html_text(verdict_line(report)));
  const std::string part = html_text(file_name(json["input"]["model"]));
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      // The page asks nothing of any network, and says so to the browser.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src "
      "'unsafe-inline'; "
      "style-src 'unsafe-inline'; img-src data: blob:\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"generator\" content=\"" +
      html_text(std::string(json["input"]["software"])) + "\">\n<title>" +
      std::string(verdict_sign(verdict).word) + ": " + part + "</title>\n<style>\n";
  page += kPageStyle;
  page += "</style>\n</head>\n<body>\n<header class=\"verdict " + verdict +
          "\"><span class=\"symbol\" aria-hidden=\"true\">" + verdict_sign(verdict).symbol +
          "</span><div><h1>" + line + "</h1>\n<ul class=\"summary\">" + summary(json) +
          "</ul>\n<ul class=\"counts\" aria-label=\"Faces by verdict\">" + verdict_counts(json) + "</ul>" +
          interruption(json) + "</div></header>\n";
  page +=
      "<main>\n<section id=\"picture\" aria-label=\"The part\"><noscript><p>The picture of the part, the "
      "views and the "
      "sphere of normals need JavaScript; everything else is here.</p></noscript></section>\n";
  page += faces_section(json) + findings_section(json) + pose_section(json) + measuring_section(json);
  page += "<section id=\"views\"></section>\n<section id=\"normals\"></section>\n";
  page += relations_section(json) + facts_section(json);
  page +=
      "</main>\n<footer><p>Deviation is positive for excess material. U is the expanded uncertainty, k = 2. "
      "Written by " +
      html_text(std::string(json["input"]["software"])) +
      "; the same numbers in full stand in report.json.</p></footer>\n";
  page += "<script type=\"application/json\" id=\"data\">" + script_json(page_data(report, std::move(json))) +
          "</script>\n<script>\n";
  page += kPageScript;
  return page + "</script>\n</body>\n</html>\n";
}

}  // namespace tetragauge
