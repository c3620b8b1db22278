// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/inspect_faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/inspect/decide.hpp"
#include "host/inspect/measure_face.hpp"

namespace tetragauge {
namespace {

constexpr size_t kLeastPoints = 30;  // fewer are not a measurement

// What the rays that should have met a face found.
struct Sight {
  std::vector<uint32_t> on;  // points of the face
  size_t met = 0;            // rays that should have met it
  size_t behind = 0;         // went clearly through where its material should be
  size_t elsewhere = 0;      // points at another surface or off by more than the gate
};

// A measured face's points belong to its model face's surface; among patches of one surface the ray decides.
// A point on no paired measured face belongs to the model face that its ray meets, if it lies near. Rays that
// meet another face than their point's are at an edge, and left out.
std::vector<Sight> sort_points(const Solid& model, const MeasuredFaces& measured, const CastScan& cast,
                               const Match& match) {
  std::vector<int> surface_of_point(cast.face.size(), 0);
  std::vector<bool> paired(model.faces().size(), false);
  for (const FacePair& pair : match.pairs) {
    const size_t face = static_cast<size_t>(pair.model) - 1;
    paired[face] = true;
    for (const uint32_t i : measured.face_points[static_cast<size_t>(pair.measured) - 1])
      surface_of_point[i] = model.faces()[face].surface;
  }
  std::vector<Sight> sights(model.faces().size());
  for (uint32_t i = 0; i < cast.face.size(); ++i) {
    if (cast.face[i] < 0) continue;
    const size_t face = static_cast<size_t>(cast.face[i]);
    Sight& sight = sights[face];
    ++sight.met;
    const bool near = std::abs(cast.deviation_mm[i]) <= match.max_offset_mm;
    const bool of_this = surface_of_point[i] == model.faces()[face].surface;
    if (of_this || (near && surface_of_point[i] == 0 && !paired[face])) {
      sight.on.push_back(i);
    } else {
      ++sight.elsewhere;
      if (!near && cast.beyond_mm[i] > match.max_offset_mm) ++sight.behind;
    }
  }
  return sights;
}

std::string in_words(const char* format, double a, double b = 0) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

double form_tolerance(const FaceTolerance& tolerance) {
  if (tolerance.flatness_mm) return *tolerance.flatness_mm;
  if (tolerance.profile_mm) return *tolerance.profile_mm;
  return 0;
}

}  // namespace

void inspect_faces(const Scan& scan, const Solid& model, const MeasuredFaces& measured, const CastScan& cast,
                   const Tolerances& tolerances, const InspectOptions& options, Inspection& inspection) {
  const Match& match = inspection.match;
  const std::vector<Sight> sights = sort_points(model, measured, cast, match);
  const std::vector<FaceOutline> outlines = face_outlines(model);
  inspection.extra_faces = match.unmatched_measured;
  inspection.point_deviation_mm.assign(scan.size(), 0.0f);
  inspection.point_face.assign(scan.size(), 0);
  for (size_t i = 0; i < scan.size(); ++i)
    if (cast.face[i] >= 0) inspection.point_deviation_mm[i] = static_cast<float>(cast.deviation_mm[i]);

  for (size_t k = 0; k < model.faces().size(); ++k) {
    const Face& face = model.faces()[k];
    const Sight& sight = sights[k];
    const FaceTolerance tolerance = tolerances.of(face);
    const bool skipped = tolerances.skip.contains(face.id);
    const bool wanted = has_tolerance(tolerance) && !skipped;
    FaceInspection out;
    out.model_id = face.id;
    double area_mm2 = 0;
    for (const FacePair& pair : match.pairs) {
      if (pair.model != face.id) continue;
      if (out.measured_id == 0) out.measured_id = pair.measured;
      area_mm2 += measured.faces()[static_cast<size_t>(pair.measured) - 1].area_mm2;
    }
    for (const uint32_t i : sight.on) inspection.point_face[i] = face.id;
    out.points_used = sight.on.size();
    out.points_rejected = sight.elsewhere;

    // More than half of the rays went through, and hardly one found it: it is not there.
    const bool absent = out.measured_id == 0 && sight.met >= kLeastPoints && 2 * sight.behind > sight.met &&
                        5 * sight.on.size() < sight.met;
    if (absent) {
      inspection.missing_faces.push_back(face.id);
      if (wanted) out.verdict = Verdict::fail;
      out.reason = in_words("rays prove it absent: %.0f of %.0f went through its place",
                            static_cast<double>(sight.behind), static_cast<double>(sight.met));
    } else if (sight.on.size() < kLeastPoints) {
      if (wanted) out.verdict = Verdict::not_measured;
      out.reason = in_words("not seen: %.0f points", static_cast<double>(sight.on.size()));
    } else {
      measure_face(
          {face, outlines[k], cast, sight.on, area_mm2, form_tolerance(tolerance), scan.header.u_cal_mm},
          match, out);
      if (face.type != SurfaceType::plane && !match.undetermined.empty()) {
        // A plane's offset does not feel the part moving where nothing holds it; a curved face's does.
        out.measured = false;
        if (wanted) out.verdict = Verdict::not_measured;
        out.reason = "the part's pose is undetermined, and with it where this face should be";
      } else if (!out.measured) {
        out.reason = "its points lie on a line";
        if (wanted) out.verdict = Verdict::not_measured;
      } else if (out.coverage < tolerances.min_coverage) {
        out.measured = false;
        if (wanted) out.verdict = Verdict::not_measured;
        out.reason = in_words("%.0f %% of its area seen, %.0f %% wanted", 100 * out.coverage,
                              100 * tolerances.min_coverage);
      } else if (wanted) {
        judge_face(out, tolerance, options.rule);
      }
      if (face.type != SurfaceType::plane && out.reason.empty())
        out.reason = std::string(surface_type_name(face.type)) + ": compared point by point, not fitted";
    }
    if (skipped) {
      out.verdict = Verdict::skipped;
      if (out.reason.empty()) out.reason = "skipped by the tolerance file";
    }
    inspection.faces.push_back(std::move(out));
  }
}

void judge_extra_faces(const Solid& model, const MeasuredFaces& measured, const CastScan& cast,
                       const Tolerances& tolerances, Inspection& inspection) {
  if (!tolerances.given) return;
  for (const int id : inspection.extra_faces) {
    size_t off = 0;
    const auto& points = measured.face_points[static_cast<size_t>(id) - 1];
    for (const uint32_t i : points) {
      if (cast.face[i] < 0) {  // the ray meets no material of the model at all
        ++off;
        continue;
      }
      const Face& face = model.faces()[static_cast<size_t>(cast.face[i])];
      if (tolerances.skip.contains(face.id)) continue;
      off += std::abs(cast.deviation_mm[i]) > offset_limit(tolerances.of(face)) + 3 * cast.sigma_mm[i];
    }
    if (2 * off > points.size()) inspection.faces_out_of_model.push_back(id);
  }
}

}  // namespace tetragauge
