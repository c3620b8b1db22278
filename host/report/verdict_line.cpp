// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/verdict_line.hpp"

#include <algorithm>
#include <cmath>

#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

// The face that decides: of those with the verdict of the whole, the one farthest beyond its limit.
const FaceInspection* deciding_face(const Inspection& inspection, Verdict verdict) {
  const FaceInspection* worst = nullptr;
  const auto beyond = [](const FaceInspection& face) {
    // A face that is not there at all has no deviation, and is worse than any that has.
    return face.decided_by ? std::abs(face.decided_by->deviation) / face.decided_by->limit : 1e300;
  };
  for (const FaceInspection& face : inspection.faces)
    if (face.verdict == verdict && (!worst || beyond(face) > beyond(*worst))) worst = &face;
  return worst;
}

std::string what_is_out(const Criterion& criterion, const Tolerances& tolerances) {
  std::string what = criterion.name == "flatness"           ? "out of flat"
                     : criterion.name == "radius"           ? "out in its radius"
                     : criterion.name == "parallelism"      ? "out of parallel"
                     : criterion.name == "perpendicularity" ? "out of square"
                     : criterion.name == "angularity"       ? "out in its angle"
                     : criterion.name == "position"         ? "out of position"
                                                            : "out";
  if (const Datum* datum = tolerances.datum(criterion.datum))
    what += print(" to datum %s (face %d)", datum->name.c_str(), datum->face);
  return what;
}

std::string face_sentence(const FaceInspection& face, const Report& report) {
  const Face& nominal = report.model.faces()[static_cast<size_t>(face.model_id) - 1];
  const std::string name =
      print("face %d (%s)", face.model_id, std::string(surface_type_name(nominal.type)).c_str());
  // What a face is undecided for may stand in its reason alone: a datum that was not measured.
  if (!face.decided_by || face.decided_by->verdict != face.verdict) return name + ": " + face.reason;
  const Criterion& by = *face.decided_by;
  if (face.candidate_with > 0) {
    return print(
        "faces %d and %d are %.3f mm +- %.3f mm out in their distance, limit %.3f mm; which of them moved "
        "cannot be told",
        std::min(face.model_id, face.candidate_with), std::max(face.model_id, face.candidate_with),
        by.deviation, by.U, by.limit);
  }
  const char* unit = by.is_angle() ? "mrad" : "mm";
  return name + print(" is %.3f %s +- %.3f %s ", by.deviation, unit, by.U, unit) +
         what_is_out(by, report.tolerances) + print(", limit %.3f %s", by.limit, unit);
}

// What fails beside the model's own faces: "" if nothing.
std::string surplus_and_missing(const Inspection& inspection) {
  size_t missing = 0, excess = 0, surplus = 0;
  for (const MaterialFault& fault : inspection.material_faults) ++(fault.missing ? missing : excess);
  for (const ExtraFace& extra : inspection.extra_faces) surplus += extra.out_of_tolerance;
  std::string text;
  const auto add = [&](size_t count, const char* what, const char* thing) {
    if (count == 0) return;
    if (!text.empty()) text += ", ";
    text += print(what, count) + print(" %s%s", thing, count == 1 ? "" : "s");
  };
  add(missing, "material missing in %zu", "place");
  add(excess, "material in excess in %zu", "place");
  add(surplus, "%zu measured", "face");
  if (surplus > 0) text += " that the model does not have";
  return text;
}

}  // namespace

std::string material_sentence(const MaterialFault& fault) {
  std::string text = print("material %s on face %d near (%.1f, %.1f, %.1f) mm: %zu rays %s",
                           fault.missing ? "missing" : "in excess", fault.face, fault.point_mm.x() + 0.0,
                           fault.point_mm.y() + 0.0, fault.point_mm.z() + 0.0, fault.rays,
                           fault.missing ? "went through" : "stopped short");
  if (fault.depth_mm > 0) text += print(", %.3f mm off the face", fault.depth_mm);
  return text;
}

std::string verdict_line(const Report& report) {
  const Inspection& inspection = report.run.inspection;
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
    case Verdict::fail: {
      const std::string besides = surplus_and_missing(inspection);
      if (face)
        return "FAIL: " + face_sentence(*face, report) + others +
               (besides.empty() ? "" : "; besides, " + besides);
      if (inspection.material_faults.size() == 1)
        return "FAIL: " + material_sentence(inspection.material_faults.front());
      return "FAIL: " + besides;
    }
    case Verdict::undecided:
      return "UNDECIDED: " + (face ? face_sentence(*face, report) : std::string()) + others;
    case Verdict::not_measured:
      return "NOT MEASURED: " + (face ? face_sentence(*face, report) : std::string()) + others;
    case Verdict::skipped:
    case Verdict::none:
      break;
  }
  return "NO VERDICT: no face has a tolerance";
}

}  // namespace tetragauge
