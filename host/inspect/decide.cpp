// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/decide.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace tetragauge {
namespace {

int severity(Verdict verdict) {
  switch (verdict) {
    case Verdict::fail:
      return 4;
    case Verdict::undecided:
      return 3;
    case Verdict::not_measured:
      return 2;
    case Verdict::pass:
      return 1;
    case Verdict::skipped:
    case Verdict::none:
      return 0;
  }
  return 0;
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::undecided:
      return "undecided";
    case Verdict::not_measured:
      return "not_measured";
    case Verdict::skipped:
      return "skipped";
    case Verdict::none:
      return "none";
  }
  return "none";
}

std::string_view rule_name(InspectOptions::Rule rule) {
  switch (rule) {
    case InspectOptions::Rule::guarded:
      return "guarded";
    case InspectOptions::Rule::iso14253:
      return "iso14253-1:2017";
    case InspectOptions::Rule::simple:
      return "simple";
  }
  return "guarded";
}

Verdict decide(double deviation_mm, double U_mm, double limit_mm, InspectOptions::Rule rule) {
  double guard = 0;
  if (rule == InspectOptions::Rule::guarded) guard = U_mm;
  if (rule == InspectOptions::Rule::iso14253) guard = 1.65 / 2 * U_mm;
  const double size = std::abs(deviation_mm);
  if (size + guard <= limit_mm) return Verdict::pass;
  if (size - guard > limit_mm) return Verdict::fail;
  return Verdict::undecided;
}

Verdict worse(Verdict a, Verdict b) {
  return severity(b) > severity(a) ? b : a;
}

double offset_limit(const FaceTolerance& tolerance) {
  double limit = 1e300;
  if (tolerance.offset_mm) limit = std::min(limit, *tolerance.offset_mm);
  if (tolerance.profile_mm) limit = std::min(limit, *tolerance.profile_mm / 2);
  return limit;
}

bool has_tolerance(const FaceTolerance& tolerance) {
  return tolerance.profile_mm || tolerance.offset_mm || tolerance.flatness_mm;
}

void judge_face(FaceInspection& face, const FaceTolerance& tolerance, InspectOptions::Rule rule) {
  double nearest = -1e300;
  const auto judge = [&](const char* criterion, double deviation, double U, std::optional<double> limit) {
    if (!limit) return;
    const Verdict verdict = decide(deviation, U, *limit, rule);
    const double use = std::abs(deviation) / *limit;
    const bool decisive = severity(verdict) > severity(face.verdict) ||
                          (severity(verdict) == severity(face.verdict) && use > nearest);
    if (!decisive) return;
    nearest = use;
    face.verdict = verdict;
    face.criterion = criterion;
    face.deviation_mm = deviation;
    face.U_mm = U;
    face.limit_mm = *limit;
  };
  face.verdict = Verdict::none;
  judge("offset", face.offset_mm, face.U_offset_mm, tolerance.offset_mm);
  std::optional<double> half;
  if (tolerance.profile_mm) half = *tolerance.profile_mm / 2;
  // The largest deviation carries the sign of the offset: material too much or too little.
  judge("profile", std::copysign(face.profile_mm, face.offset_mm), face.U_profile_mm, half);
  judge("flatness", face.form_mm, face.U_form_mm, tolerance.flatness_mm);
}

void judge_distances(const Solid& model, const Tolerances& tolerances, std::vector<FaceInspection>& faces,
                     InspectOptions::Rule rule) {
  for (size_t a = 0; a < faces.size(); ++a) {
    for (size_t b = a + 1; b < faces.size(); ++b) {
      const Face &first = model.faces()[a], &second = model.faces()[b];
      if (first.type != SurfaceType::plane || second.type != SurfaceType::plane) continue;
      if (!faces[a].measured || !faces[b].measured) continue;
      const auto open = [](const FaceInspection& face) {
        return face.verdict == Verdict::undecided || face.candidate_with > 0;
      };
      if (!open(faces[a]) || !open(faces[b])) continue;
      const double cosine = first.normal.dot(second.normal);
      if (std::abs(cosine) < 1 - 1e-8) continue;
      // Moving the part adds to one what it takes from the other (opposed faces), or adds to both alike.
      const double distance =
          cosine < 0 ? faces[a].offset_mm + faces[b].offset_mm : faces[a].offset_mm - faces[b].offset_mm;
      const double limit = offset_limit(tolerances.of(first)) + offset_limit(tolerances.of(second));
      const double U = 2 * std::hypot(faces[a].u_offset_own_mm, faces[b].u_offset_own_mm);
      if (limit > 1e200 || decide(distance, U, limit, rule) != Verdict::fail) continue;
      for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
        FaceInspection& face = faces[one];
        face.verdict = Verdict::fail;
        face.candidate_with = faces[other].model_id;
        face.criterion = "distance";
        face.deviation_mm = distance;
        face.U_mm = U;
        face.limit_mm = limit;
        std::array<char, 160> text{};
        std::snprintf(text.data(), text.size(),
                      "distance to face %d is %.3f mm out: which of the two moved cannot be told",
                      faces[other].model_id, distance);
        face.reason = text.data();
      }
    }
  }
}

Verdict judge_part(const Inspection& inspection, const Solid& model, const Tolerances& tolerances) {
  Verdict verdict = Verdict::none;
  bool any = false;
  for (size_t k = 0; k < inspection.faces.size(); ++k) {
    const Face& face = model.faces()[k];
    if (tolerances.skip.contains(face.id) || !has_tolerance(tolerances.of(face))) continue;
    any = true;
    verdict = worse(verdict, inspection.faces[k].verdict);
  }
  if (any && !(inspection.faces_out_of_model.empty() && inspection.material_faults.empty()))
    verdict = Verdict::fail;
  return verdict;
}

}  // namespace tetragauge
