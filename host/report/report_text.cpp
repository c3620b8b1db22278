// SPDX-License-Identifier: GPL-3.0-or-later
// report.txt: the verdict first, then the pose and a table. No line is longer than 100 columns.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "host/inspect/decide.hpp"
#include "host/report/report.hpp"

namespace tetragauge {
namespace {

constexpr size_t kColumns = 100;

[[gnu::format(printf, 1, 2)]] std::string print(const char* format, ...) {
  std::array<char, 400> text{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

// Breaks at spaces; lines after the first are indented.
std::string wrapped(const std::string& text) {
  std::string out, line;
  size_t at = 0;
  while (at < text.size()) {
    size_t end = text.find(' ', at);
    if (end == std::string::npos) end = text.size();
    const std::string word = text.substr(at, end - at);
    if (!line.empty() && line.size() + 1 + word.size() > kColumns) {
      out += line + "\n";
      line = "   ";
    }
    line += (line.empty() ? "" : " ") + word;
    at = end + 1;
  }
  return out + line + "\n";
}

std::string type_of(const Solid& model, int id) {
  for (const Face& face : model.faces())
    if (face.id == id) return std::string(surface_type_name(face.type));
  return "";
}

// The face that decides: of those with the verdict of the whole, the one farthest beyond its limit.
const FaceInspection* deciding_face(const Inspection& inspection, Verdict verdict) {
  const FaceInspection* worst = nullptr;
  const auto beyond = [](const FaceInspection& face) {
    // A face that is not there at all has no deviation, and is worse than any that has.
    if (face.criterion.empty()) return 1e300;
    return std::abs(face.deviation_mm) / face.limit_mm;
  };
  for (const FaceInspection& face : inspection.faces)
    if (face.verdict == verdict && (!worst || beyond(face) > beyond(*worst))) worst = &face;
  return worst;
}

std::string face_sentence(const FaceInspection& face, const Solid& model) {
  const std::string name = print("face %d (%s)", face.model_id, type_of(model, face.model_id).c_str());
  if (face.criterion.empty()) return name + ": " + face.reason;
  if (face.candidate_with > 0) {
    return print(
        "faces %d and %d are %.3f mm +- %.3f mm out in their distance, limit %.3f mm; which of them moved "
        "cannot be told",
        std::min(face.model_id, face.candidate_with), std::max(face.model_id, face.candidate_with),
        face.deviation_mm, face.U_mm, face.limit_mm);
  }
  const char* what = face.criterion == "flatness" ? "out of flat" : "out";
  return name +
         print(" is %.3f mm +- %.3f mm %s, limit %.3f mm", face.deviation_mm, face.U_mm, what, face.limit_mm);
}

std::string material_sentence(const MaterialFault& fault) {
  return print("material %s on face %d near (%.1f, %.1f, %.1f) mm: %zu rays %s, %.3f mm off the face",
               fault.missing ? "missing" : "in excess", fault.face, fault.point_mm.x() + 0.0,
               fault.point_mm.y() + 0.0, fault.point_mm.z() + 0.0, fault.rays,
               fault.missing ? "went through" : "stopped short", fault.depth_mm);
}

std::string verdict_line(const InspectionRun& run, const Solid& model) {
  const Inspection& inspection = run.inspection;
  size_t judged = 0, same = 0, skipped = 0;
  for (const FaceInspection& face : inspection.faces) {
    judged += face.verdict != Verdict::none && face.verdict != Verdict::skipped;
    same += face.verdict == inspection.verdict;
    skipped += face.verdict == Verdict::skipped;
  }
  const FaceInspection* face = deciding_face(inspection, inspection.verdict);
  const std::string others = same > 1 ? print("; %zu faces in all", same) : "";
  switch (inspection.verdict) {
    case Verdict::pass:
      return print("PASS: all %zu faces with a tolerance are within it", judged) +
             (skipped > 0 ? print(", %zu skipped", skipped) : "");
    case Verdict::fail:
      if (face) return "FAIL: " + face_sentence(*face, model) + others;
      if (!inspection.material_faults.empty()) {
        const size_t count = inspection.material_faults.size();
        return "FAIL: " + material_sentence(inspection.material_faults.front()) +
               (count > 1 ? print("; %zu such places in all", count) : "");
      }
      return print("FAIL: %zu measured face%s that the model does not have, out of tolerance",
                   inspection.faces_out_of_model.size(),
                   inspection.faces_out_of_model.size() == 1 ? "" : "s");
    case Verdict::undecided:
      return "UNDECIDED: " + (face ? face_sentence(*face, model) : std::string()) + others;
    case Verdict::not_measured:
      return "NOT MEASURED: " + (face ? face_sentence(*face, model) : std::string()) + others;
    case Verdict::skipped:
    case Verdict::none:
      break;
  }
  return "NO VERDICT: no face has a tolerance";
}

std::string table(const InspectionRun& run, const Solid& model, const Tolerances& tolerances) {
  std::string out =
      "face type       points cover   offset mm   +- U   tilt mrad   form mm  profile   limit verdict\n";
  for (size_t k = 0; k < run.inspection.faces.size(); ++k) {
    const FaceInspection& in = run.inspection.faces[k];
    const Face& face = model.faces()[k];
    const FaceTolerance tolerance = tolerances.of(face);
    out += print("%4d %-8.8s %8zu %4.0f%%", face.id, std::string(surface_type_name(face.type)).c_str(),
                 in.points_used, 100 * in.coverage);
    if (in.measured || in.coverage > 0) {
      out += print(" %+11.4f %6.4f %11s %9.4f %8.4f", in.offset_mm + 0.0, in.U_offset_mm,
                   face.type == SurfaceType::plane ? print("%.3f", 1e3 * in.tilt_rad).c_str() : "-",
                   in.form_mm, in.profile_mm);
    } else {
      out += print(" %11s %6s %11s %9s %8s", "-", "-", "-", "-", "-");
    }
    const double limit = tolerance.profile_mm ? *tolerance.profile_mm / 2 : tolerance.offset_mm.value_or(0);
    out += limit > 0 ? print(" %7.3f", limit) : print(" %7s", "-");
    out += " " + std::string(verdict_name(in.verdict)) + "\n";
  }
  return out;
}

std::string pose_lines(const Match& match) {
  const Vec3 deg = degrees_from_rotation(match.T_model_part.R);
  const Vec3& t = match.T_model_part.t;
  std::string out =
      print("pose (model from part): Rz(%.4f) Ry(%.4f) Rx(%.4f) degrees, t = (%.4f, %.4f, %.4f) mm\n",
            deg.z() + 0.0, deg.y() + 0.0, deg.x() + 0.0, t.x() + 0.0, t.y() + 0.0, t.z() + 0.0);
  const Vec3 turn = match.covariance.diagonal().head<3>().cwiseMax(0.0).cwiseSqrt() * 1e3;
  const Vec3 shift = match.covariance.diagonal().tail<3>().cwiseMax(0.0).cwiseSqrt();
  out += print("  standard uncertainty at the part's centroid: %.4f %.4f %.4f mrad, %.4f %.4f %.4f mm\n",
               turn.x(), turn.y(), turn.z(), shift.x(), shift.y(), shift.z());
  const size_t used = static_cast<size_t>(std::count_if(match.pairs.begin(), match.pairs.end(),
                                                        [](const FacePair& p) { return p.used_in_pose; }));
  out += print("  fitted to %zu of %zu paired faces, rms %.4f mm\n", used, match.pairs.size(), match.rms_mm);
  if (!match.equivalents.empty()) {
    out += print("%zu more pose%s the data cannot tell from this one, the first:\n", match.equivalents.size(),
                 match.equivalents.size() == 1 ? "" : "s");
    out += wrapped("  " + match.equivalents.front().why);
  }
  for (const FreeDirection& free : match.undetermined) {
    out += print("undetermined: %s %s (%.4f, %.4f, %.4f)\n",
                 free.kind == FreeDirection::Kind::translation ? "translation along" : "rotation about",
                 free.kind == FreeDirection::Kind::translation ? "" : "the axis", free.axis.x() + 0.0,
                 free.axis.y() + 0.0, free.axis.z() + 0.0);
  }
  return out;
}

}  // namespace

std::string report_text(const InspectionRun& run, const Scan& scan, const Solid& model,
                        const Tolerances& tolerances, const ReportInput& input) {
  std::string out = wrapped(verdict_line(run, model));
  out += wrapped("scan: " + input.scan_name + print(", %zu points", scan.size()));
  out += wrapped("model: " + input.model_name + print(", %zu faces", model.faces().size()));
  if (!input.tolerances_name.empty())
    out += wrapped("tolerances: " + input.tolerances_name + ", rule " + run.inspection.rule);
  if (run.inspection.smallest_feature_mm > 0) {
    out += wrapped(
        print("resolution: a hole, boss or notch under about %.1f mm can go unseen; a finer pitch sees it",
              run.inspection.smallest_feature_mm));
  }
  out += "\n" + pose_lines(run.inspection.match) + "\n" + table(run, model, tolerances);
  std::string remarks;
  for (const FaceInspection& face : run.inspection.faces)
    if (!face.reason.empty()) remarks += wrapped(print("face %d: ", face.model_id) + face.reason);
  for (const MaterialFault& fault : run.inspection.material_faults)
    remarks += wrapped(material_sentence(fault));
  for (const int id : run.inspection.extra_faces) {
    const Face& face = run.measured.faces()[static_cast<size_t>(id) - 1];
    const Vec3 at = run.inspection.match.T_model_part * face.point_mm;
    remarks += wrapped(print("extra face (%s, %.1f mm2) at (%.2f, %.2f, %.2f) mm in the model's frame",
                             std::string(surface_type_name(face.type)).c_str(), face.area_mm2, at.x(), at.y(),
                             at.z()));
  }
  if (!remarks.empty()) out += "\n" + remarks;
  return out;
}

}  // namespace tetragauge
