// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "host/report/page/html_number.hpp"
#include "host/report/page/html_text.hpp"
#include "host/report/page/page_sections.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

struct VerdictName {
  const char *key, *symbol, *word;
};
// In the order of the table, the worst first.
constexpr std::array kVerdicts{VerdictName{"fail", "✗", "Fail"},
                               VerdictName{"undecided", "?", "Undecided"},
                               VerdictName{"not_measured", "○", "Not measured"},
                               VerdictName{"pass", "✓", "Pass"},
                               VerdictName{"skipped", "–", "Skipped"},
                               VerdictName{"none", "·", "No tolerance"}};

size_t severity(const std::string& verdict) {
  const auto at = std::find_if(kVerdicts.begin(), kVerdicts.end(),
                               [&](const VerdictName& v) { return verdict == v.key; });
  return static_cast<size_t>(at - kVerdicts.begin());
}

// Of the criterion that decided, deviation, U and limit in its own unit.
struct Decision {
  ordered_json deviation, U, limit;
  bool is_angle = false;
};

Decision decision(const ordered_json& face) {
  const ordered_json by = at_path(face, {"decided_by"});
  if (by.is_null()) return {};
  const bool is_angle = by.contains("deviation_mrad");
  const auto get = [&](const char* mm, const char* mrad) { return at_path(by, {is_angle ? mrad : mm}); };
  return {get("deviation_mm", "deviation_mrad"), get("U_mm", "U_mrad"), get("limit_mm", "limit_mrad"),
          is_angle};
}

// Share of the limit that is used up. A face that fails without a number is not there, or not where it should
// be: worse than any that has one.
double strain(const ordered_json& face) {
  const Decision d = decision(face);
  if (d.deviation.is_null() && face["verdict"] == "fail") return 1e300;
  if (!d.deviation.is_number() || !d.limit.is_number() || !(d.limit.get<double>() > 0)) return 0;
  return std::abs(d.deviation.get<double>()) / d.limit.get<double>();
}

// Deviation as a dot with its uncertainty as a bar, on a scale whose limits are at a quarter and three
// quarters; beyond the scale an arrow.
std::string bullet(const Decision& d) {
  if (!d.deviation.is_number() || !d.U.is_number() || !d.limit.is_number()) return "";
  const double limit = d.limit.get<double>();
  if (!(limit > 0)) return "";
  const auto x = [&](double value) { return std::clamp(60 + 30 * value / limit, 3.0, 117.0); };
  const double at = d.deviation.get<double>(), U = d.U.get<double>();
  std::string svg =
      "<svg class=\"bullet\" width=\"92\" height=\"16\" viewBox=\"0 0 120 16\" aria-hidden=\"true\">"
      "<rect class=\"zone\" x=\"30\" y=\"3\" width=\"60\" height=\"10\"/>"
      "<path class=\"axis\" d=\"M60 1V15\"/><path class=\"limit\" d=\"M30 1V15M90 1V15\"/>";
  svg += print("<path class=\"u\" d=\"M%.1f 8H%.1f\"/>", x(at - U), std::max(x(at + U), x(at - U) + 0.5));
  if (std::abs(at) > 1.9 * limit) {
    svg += at > 0 ? "<path class=\"dot\" d=\"M110 3L118 8L110 13Z\"/>"
                  : "<path class=\"dot\" d=\"M10 3L2 8L10 13Z\"/>";
  } else {
    svg += print("<circle class=\"dot\" cx=\"%.1f\" cy=\"8\" r=\"3.5\"/>", x(at));
  }
  return svg + "</svg>";
}

std::string row(const ordered_json& face) {
  const std::string verdict = face["verdict"];
  const VerdictSign sign = verdict_sign(verdict);
  const int id = face["id"];
  const Decision d = decision(face);
  const ordered_json& deviations = face["deviations"];
  std::string by;
  if (face.contains("decided_by")) {
    by = face["decided_by"].value("criterion", std::string());
    if (face["decided_by"].contains("datum")) by += " to " + std::string(face["decided_by"]["datum"]);
  }
  std::string out = print(
      "<tr data-face=\"%d\" class=\"%s\"><th scope=\"row\"><a href=\"#face-%d\" id=\"face-%d\">%d</a></th>",
      id, verdict.c_str(), id, id, id);
  const auto cell = [&](const std::string& text, const char* of = "number") {
    out += print("<td class=\"%s\">", of) + text + "</td>";
  };
  out += "<td class=\"verdict\"><span class=\"badge " + verdict + "\"><span aria-hidden=\"true\">" +
         sign.symbol + "</span> " + sign.word + "</span></td>";
  cell(html_text(std::string(face["type"])), "text");
  const std::string reason = html_text(face.value("reason", std::string()));
  if (by.empty() && !reason.empty()) {
    out += "<td class=\"reason\" colspan=\"5\" title=\"" + reason + "\"><div>" + reason + "</div></td>";
  } else {
    cell(by.empty() ? "–" : html_text(by), "text");
    cell(html_number(d.deviation, 3, true) + (d.is_angle ? " mrad" : ""));
    cell(html_number(d.U, 3));
    cell(html_number(d.limit, 3));
    cell(bullet(d), "graph");
  }
  cell(html_number(at_path(deviations, {"offset_mm"}), 3, true));
  cell(html_number(at_path(deviations, {"tilt_mrad"}), 2));
  cell(html_number(at_path(deviations, {"form_mm"}), 3));
  cell(html_number(100 * face["coverage"].get<double>(), 0) + " %");
  cell(html_number(face["points_used"], 0));
  return out + "</tr>\n";
}

}  // namespace

VerdictSign verdict_sign(const std::string& verdict) {
  const size_t at = severity(verdict);
  return at < kVerdicts.size() ? VerdictSign{kVerdicts[at].symbol, kVerdicts[at].word}
                               : VerdictSign{"·", "No tolerance"};
}

std::string verdict_counts(const ordered_json& json) {
  std::string out;
  for (const VerdictName& verdict : kVerdicts) {
    const auto count =
        std::count_if(json["faces"].begin(), json["faces"].end(),
                      [&](const ordered_json& face) { return face["verdict"] == verdict.key; });
    if (count == 0) continue;
    out += print("<li class=\"badge %s\"><span aria-hidden=\"true\">%s</span> %td %s</li>", verdict.key,
                 verdict.symbol, count, verdict.word);
  }
  return out;
}

std::string faces_section(const ordered_json& json) {
  std::vector<ordered_json> faces(json["faces"].begin(), json["faces"].end());
  std::stable_sort(faces.begin(), faces.end(), [](const ordered_json& a, const ordered_json& b) {
    const size_t sa = severity(a["verdict"]), sb = severity(b["verdict"]);
    return sa != sb ? sa < sb : strain(a) > strain(b);
  });
  std::string out =
      "<section id=\"faces\"><h2>Faces</h2>\n<div class=\"scroll\"><table class=\"faces\">"
      "<caption>Worst first. Lengths in mm, + is excess material, U at k = 2.</caption>\n<thead><tr>"
      "<th scope=\"col\">Face</th><th scope=\"col\">Verdict</th><th scope=\"col\">Type</th>"
      "<th scope=\"col\">Judged by</th><th scope=\"col\" class=\"number\">Deviation</th>"
      "<th scope=\"col\" class=\"number\">± U</th><th scope=\"col\" class=\"number\">± Limit</th>"
      "<th scope=\"col\"><span class=\"limits-head\">−limit&emsp;+limit</span></th>"
      "<th scope=\"col\" class=\"number\">Offset</th><th scope=\"col\" class=\"number\">Tilt mrad</th>"
      "<th scope=\"col\" class=\"number\">Form</th><th scope=\"col\" class=\"number\">Covered</th>"
      "<th scope=\"col\" class=\"number\">Points</th></tr></thead>\n<tbody>\n";
  for (const ordered_json& face : faces) out += row(face);
  return out + "</tbody></table></div></section>\n";
}

}  // namespace tetragauge
