// SPDX-License-Identifier: GPL-3.0-or-later
// report.txt: the verdict first, then what holds the part, the table of faces, and what is remarkable. No
// line is longer than 100 columns.
#include <algorithm>
#include <cmath>

#include "host/match/turn_text.hpp"
#include "host/report/print_text.hpp"
#include "host/report/report.hpp"
#include "host/report/text_tables.hpp"
#include "host/report/verdict_line.hpp"

namespace tetragauge {
namespace {

std::string alignment_lines(const Inspection& inspection) {
  const Alignment& alignment = inspection.alignment;
  if (!alignment.problem.empty())
    return wrapped("held by: best fit, NOT by the datums asked for: " + alignment.problem);
  if (alignment.datums.empty()) return "held by: best fit to all faces in place (no datums)\n";
  std::string text = "held by: ";
  for (const Alignment::Held& held : alignment.datums) {
    if (&held != &alignment.datums.front()) text += ", then ";
    text += print("datum %s (face %d: %d rotation%s, %d translation%s)", held.datum.c_str(), held.face,
                  held.rotations, held.rotations == 1 ? "" : "s", held.translations,
                  held.translations == 1 ? "" : "s");
  }
  int fixed = 0;
  for (const Alignment::Held& held : alignment.datums) fixed += held.rotations + held.translations;
  if (fixed < 6) text += ", the rest by best fit";
  return wrapped(text);
}

std::string found_by_lines(const Match& match) {
  if (match.found_by == MatchedBy::surface)
    return wrapped("  found by: all points against the model's whole surface, since " +
                   match.surface_fit.why +
                   print("; %.1f %% of the points lie on it, scatter %.4f mm",
                         100 * match.surface_fit.explained, match.surface_fit.scatter_mm));
  const auto used =
      std::count_if(match.pairs.begin(), match.pairs.end(), [](const FacePair& p) { return p.used_in_pose; });
  return print("  found by: its planes, %td of %zu paired faces, rms %.4f mm\n", used, match.pairs.size(),
               match.rms_mm);
}

std::string pose_lines(const Match& match) {
  const Vec3 deg = degrees_from_rotation(match.T_model_part.R);
  std::string out = wrapped("pose (model from part): Rz(" + number_text(deg.z(), 4) + ") Ry(" +
                            number_text(deg.y(), 4) + ") Rx(" + number_text(deg.x(), 4) +
                            ") degrees, t = " + vector_text(match.T_model_part.t, 4) + " mm");
  const Vec3 turn = match.covariance.diagonal().head<3>().cwiseMax(0.0).cwiseSqrt() * 1e3;
  const Vec3 shift = match.covariance.diagonal().tail<3>().cwiseMax(0.0).cwiseSqrt();
  out += print("  standard uncertainty at the part's centroid: %.4f %.4f %.4f mrad, %.4f %.4f %.4f mm\n",
               turn.x(), turn.y(), turn.z(), shift.x(), shift.y(), shift.z());
  out += found_by_lines(match);
  if (!match.equivalents.empty()) {
    out += print("%zu more pose%s the data cannot tell from this one, the first:\n", match.equivalents.size(),
                 match.equivalents.size() == 1 ? "" : "s");
    out += wrapped("  " + match.equivalents.front().why);
  }
  for (const FreeDirection& free : match.undetermined) {
    const bool shift = free.kind == FreeDirection::Kind::translation;
    out += std::string("undetermined: ") + (shift ? "translation along " : "rotation about the axis ") +
           vector_text(free.axis, 4) + "\n";
  }
  return out;
}

std::string head(const Report& report) {
  const Inspection& inspection = report.run.inspection;
  std::string out = wrapped(verdict_line(report));
  for (size_t k = 0; k < report.scans.size(); ++k) {
    const std::string which = report.scans.size() > 1 ? print("scan %zu: ", k + 1) : "scan: ";
    out += wrapped(which + report.scan_files[k].name + print(", %zu points", report.scans[k].size()));
  }
  out += wrapped("model: " + report.model_file.name + print(", %zu faces", report.model.faces().size()));
  if (!report.tolerances_file.name.empty())
    out += wrapped("tolerances: " + report.tolerances_file.name + ", rule " +
                   std::string(rule_name(inspection.rule)));
  if (inspection.smallest_feature_mm > 0) {
    out += wrapped(
        print("resolution: a hole, boss or notch under about %.1f mm can go unseen; a finer pitch sees it",
              inspection.smallest_feature_mm));
  }
  return out;
}

std::string story_lines(const MeasuringStory& story) {
  std::string out = wrapped("measured by: " + story.plan);
  for (size_t k = 0; k < story.rounds.size(); ++k) {
    const MeasuringRound& round = story.rounds[k];
    const Doubts &before = round.before, &after = round.after;
    out += wrapped(
        print("round %zu: %zu directions, %zu views, %zu points, %.0f s of the machine's time; in doubt "
              "%.1f -> %.1f mm3, of it to be decided by a ray %.1f -> %.1f mm3; faces undecided %zu -> "
              "%zu, not measured %zu -> %zu",
              k + 1, round.rays, round.views, round.points, round.machine_s, before.doubtful_mm3,
              after.doubtful_mm3, before.resolvable_mm3, after.resolvable_mm3, before.undecided,
              after.undecided, before.not_measured, after.not_measured));
  }
  if (!story.end.empty()) out += wrapped("re-measuring ended: " + story.end);
  if (!story.interruption.empty())
    out += wrapped("RE-MEASURING BROKEN OFF, judged from what was measured before: " + story.interruption);
  return out;
}

std::string remarks(const Report& report) {
  const Inspection& inspection = report.run.inspection;
  std::string out;
  for (const FaceInspection& face : inspection.faces)
    if (!face.reason.empty()) out += wrapped(print("face %d: ", face.model_id) + face.reason);
  for (const MaterialFault& fault : inspection.material_faults) out += wrapped(material_sentence(fault));
  for (const ExtraFace& extra : inspection.extra_faces) {
    out += wrapped(print("extra face (%s, %.1f mm2) at ",
                         std::string(surface_type_name(extra.face.type)).c_str(), extra.face.area_mm2) +
                   vector_text(extra.face.point_mm, 2) + " mm in the model's frame" +
                   (extra.out_of_tolerance ? ", out of tolerance" : ""));
  }
  return out;
}

}  // namespace

std::string summary_text(const Report& report) {
  std::string out = head(report) + "\n" + alignment_lines(report.run.inspection);
  for (size_t k = 0; k < report.run.set_ups.size(); ++k) {
    if (report.run.set_ups.size() > 1) out += print("scan %zu, ", k + 1);
    out += pose_lines(report.run.set_ups[k].match);
  }
  if (report.story) out += "\n" + story_lines(*report.story);
  out += "\n" + faces_table(report);
  if (const std::string text = remarks(report); !text.empty()) out += "\n" + text;
  return out;
}

std::string report_text(const Report& report) {
  std::string out = summary_text(report);
  if (const std::string table = surface_table(report); !table.empty()) out += "\n" + table;
  if (const std::string table = relations_table(report); !table.empty()) out += "\n" + table;
  return out;
}

}  // namespace tetragauge
