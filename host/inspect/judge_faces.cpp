// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/judge_faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/inspect/against_datum.hpp"
#include "host/inspect/applies_to.hpp"

namespace tetragauge {
namespace {

void add_reason(FaceInspection& face, const std::string& reason) {
  face.reason += (face.reason.empty() ? "" : "; ") + reason;
}

std::string without_unit(std::string_view key) {
  return std::string(key.substr(0, key.rfind('_')));
}

// Position and orientation. Returns Verdict::undecided where the datum was not measured.
Verdict judge_against_datums(const Solid& model, const std::vector<FaceOutline>& outlines,
                             const Tolerances& tolerances, const FaceTolerance& tolerance, bool pose_is_known,
                             Rule rule, const std::vector<FaceInspection>& faces, FaceInspection& out) {
  Verdict verdict = Verdict::none;
  const size_t k = static_cast<size_t>(out.model_id) - 1;
  const Face& face = model.faces()[k];
  for (const DatumLimitKey& key : kDatumLimitKeys) {
    const auto& limit = tolerance.*key.member;
    if (!limit) continue;
    const Datum& datum = *tolerances.datum(limit->datum);
    const size_t d = static_cast<size_t>(datum.face) - 1;
    std::optional<Criterion> found =
        against_datum(key.name, {face, outlines[k], out, model.faces()[d], faces[d]});
    if (!found) {
      verdict = Verdict::undecided;
      add_reason(out, without_unit(key.name) + ": datum " + datum.name + " (face " +
                          std::to_string(datum.face) + ") was not measured");
      continue;
    }
    const bool is_position = key.name == "position_mm";
    found->name = without_unit(key.name);
    found->datum = datum.name;
    found->limit = is_position ? limit->value / 2 : limit->value;
    const bool needs_pose = is_position && (out.curve || !is_parallel(face.normal, datum.normal));
    found->verdict = needs_pose && !pose_is_known ? Verdict::undecided
                                                  : decide(found->deviation, found->U, found->limit, rule);
    out.criteria.push_back(*found);
  }
  return verdict;
}

// If the whole of a wrong distance were this face's, with its tilt and form on top: is it within its limits?
// Then the criteria that the pose left open are decided by that.
bool passes_whichever_moved(const FaceInspection& face, double distance, double U, Rule rule,
                            std::vector<Criterion>& criteria) {
  if (std::abs(face.offset_mm) > std::abs(distance) + U) return false;
  criteria = face.criteria;
  for (Criterion& criterion : criteria) {
    if (criterion.verdict != Verdict::undecided) continue;
    const bool is_profile = criterion.name == "profile";
    if (!is_profile && criterion.name != "offset") return false;
    const double on_top = is_profile ? std::max(0.0, face.profile_mm - std::abs(face.offset_mm)) : 0;
    const double U_on_top =
        is_profile ? std::sqrt(std::max(0.0, std::pow(face.U_profile_mm, 2) - std::pow(face.U_offset_mm, 2)))
                   : 0;
    criterion.deviation = std::copysign(std::abs(distance) + on_top, criterion.deviation);
    criterion.U = std::hypot(U, U_on_top);
    criterion.verdict = decide(criterion.deviation, criterion.U, criterion.limit, rule);
    if (criterion.verdict != Verdict::pass) return false;
  }
  return true;
}

}  // namespace

void conclude_criteria(FaceInspection& face) {
  face.decided_by.reset();
  for (const Criterion& criterion : face.criteria) {
    const auto use = [](const Criterion& c) { return std::abs(c.deviation) / c.limit; };
    const bool is_worse =
        !face.decided_by || worse(face.decided_by->verdict, criterion.verdict) != face.decided_by->verdict;
    const bool is_alike = face.decided_by && face.decided_by->verdict == criterion.verdict;
    if (is_worse || (is_alike && use(criterion) > use(*face.decided_by))) face.decided_by = criterion;
  }
  face.verdict = face.decided_by ? face.decided_by->verdict : Verdict::none;
}

void judge_face(FaceInspection& face, const FaceTolerance& tolerance, Rule rule, bool pose_is_known) {
  face.criteria.clear();
  const auto judge = [&](const char* name, double deviation, double U, std::optional<double> limit,
                         bool needs_pose) {
    if (!limit) return;
    const Verdict verdict =
        needs_pose && !pose_is_known ? Verdict::undecided : decide(deviation, U, *limit, rule);
    face.criteria.push_back({name, deviation, U, *limit, verdict, ""});
  };
  std::optional<double> half;
  if (tolerance.profile_mm) half = *tolerance.profile_mm / 2;
  // The largest deviation carries the sign of the offset: material too much or too little.
  judge("profile", std::copysign(face.profile_mm, face.offset_mm), face.U_profile_mm, half, true);
  judge("offset", face.offset_mm, face.U_offset_mm, tolerance.offset_mm, true);
  if (face.radius_mm) judge("radius", *face.radius_mm, face.U_radius_mm, tolerance.radius_mm, false);
  judge("flatness", face.form_mm, face.U_form_mm, tolerance.flatness_mm, false);
  conclude_criteria(face);
}

void judge_faces(const Solid& model, const std::vector<FaceOutline>& outlines, const Tolerances& tolerances,
                 Inspection& inspection) {
  const bool pose_is_known = inspection.alignment.problem.empty();
  std::vector<FaceInspection>& faces = inspection.faces;
  for (size_t k = 0; k < faces.size(); ++k) {
    FaceInspection& out = faces[k];
    const Face& face = model.faces()[k];
    const FaceTolerance tolerance = tolerances.of(face);
    if (tolerances.skip.contains(face.id)) {
      out.verdict = Verdict::skipped;
      if (out.reason.empty()) out.reason = "skipped by the tolerance file";
      continue;
    }
    if (!out.measured || !has_tolerance(tolerance)) continue;
    judge_face(out, tolerance, inspection.rule, pose_is_known);
    const Verdict without_datum = judge_against_datums(model, outlines, tolerances, tolerance, pose_is_known,
                                                       inspection.rule, faces, out);
    conclude_criteria(out);
    out.verdict = worse(out.verdict, without_datum);
    if (!pose_is_known && out.verdict == Verdict::undecided) add_reason(out, inspection.alignment.problem);
  }
}

void judge_distances(const Solid& model, const Tolerances& tolerances, std::vector<FaceInspection>& faces,
                     Rule rule) {
  for (size_t a = 0; a < faces.size(); ++a) {
    for (size_t b = a + 1; b < faces.size(); ++b) {
      const Face &first = model.faces()[a], &second = model.faces()[b];
      if (first.type != SurfaceType::plane || second.type != SurfaceType::plane) continue;
      if (!faces[a].measured || !faces[b].measured) continue;
      const auto open = [](const FaceInspection& face) {
        return face.verdict == Verdict::undecided || face.candidate_with > 0;
      };
      if (!open(faces[a]) || !open(faces[b])) continue;
      // Undecided for its own deviations, not for a datum that was not measured.
      const auto is_undecided_by_criterion = [](const FaceInspection& face) {
        return face.verdict == Verdict::undecided && face.reason.empty();
      };
      const double cosine = first.normal.dot(second.normal);
      if (std::abs(cosine) < 1 - 1e-8) continue;
      // Moving the part adds to one what it takes from the other (opposed faces), or adds to both alike.
      const double distance =
          cosine < 0 ? faces[a].offset_mm + faces[b].offset_mm : faces[a].offset_mm - faces[b].offset_mm;
      const double limit = offset_limit(tolerances.of(first)) + offset_limit(tolerances.of(second));
      const double U = 2 * std::hypot(faces[a].u_offset_own_mm, faces[b].u_offset_own_mm);
      if (limit > 1e200) continue;
      std::vector<Criterion> of_first, of_second;
      if (is_undecided_by_criterion(faces[a]) && is_undecided_by_criterion(faces[b]) &&
          passes_whichever_moved(faces[a], distance, U, rule, of_first) &&
          passes_whichever_moved(faces[b], distance, U, rule, of_second)) {
        faces[a].criteria = std::move(of_first);
        faces[b].criteria = std::move(of_second);
        for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
          conclude_criteria(faces[one]);
          faces[one].reason = "judged as if all of the wrong distance to face " +
                              std::to_string(faces[other].model_id) + " were its own";
        }
        continue;
      }
      if (decide(distance, U, limit, rule) != Verdict::fail) continue;
      for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
        FaceInspection& face = faces[one];
        face.candidate_with = faces[other].model_id;
        face.criteria.push_back({"distance", distance, U, limit, Verdict::fail, ""});
        conclude_criteria(face);
        std::array<char, 160> text{};
        std::snprintf(text.data(), text.size(),
                      "distance to face %d is %.3f mm out: which of the two moved cannot be told",
                      faces[other].model_id, distance);
        face.reason = text.data();
      }
    }
  }
}

}  // namespace tetragauge
