// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/planes_met.hpp"

#include <tbb/parallel_for.h>

#include <cmath>

#include "host/faces/assign_points.hpp"
#include "host/faces/compare_planes.hpp"
#include "host/reconstruct/average_points.hpp"

namespace tetragauge {
namespace {

// Of a face that loses more of its points, the model's face says little.
constexpr double kLeastMet = 0.5;

}  // namespace

FaceList planes_met(const Solid& solid, const RayCaster& caster, const Scan& scan, const MeasuredFaces& faces,
                    const MatchInput& input, const std::vector<RankedPose>& poses) {
  FaceList list = faces.list;
  struct Partner {
    const RigidTransform* T_model_part = nullptr;
    int surface = 0;
  };
  std::vector<Partner> partners(list.faces.size());
  for (const RankedPose& pose : poses) {
    for (const PlanePair& pair : pose.pairs) {
      Partner& partner = partners[static_cast<size_t>(input.measured.planes[pair.measured].id) - 1];
      if (partner.T_model_part) continue;
      const int model_id = input.model.planes[pair.model].id;
      partner = {&pose.pose.T_model_part, solid.faces()[static_cast<size_t>(model_id) - 1].surface};
    }
  }
  const std::vector<double> sigma_mm = floored_sigma_mm(scan);
  tbb::parallel_for(size_t{0}, partners.size(), [&](size_t k) {
    if (!partners[k].T_model_part) return;
    const RigidTransform& T = *partners[k].T_model_part;
    const std::vector<uint32_t>& points = faces.face_points[k];
    std::vector<uint32_t> met;
    for (const uint32_t i : points) {
      const std::optional<RayHit> hit =
          caster.first_hit(T * scan.ray_origins[i], T.R * scan.ray_direction(i));
      if (hit && solid.faces()[static_cast<size_t>(hit->face)].surface == partners[k].surface)
        met.push_back(i);
    }
    if (met.size() == points.size() ||
        static_cast<double>(met.size()) < kLeastMet * static_cast<double>(points.size()))
      return;
    Face& face = list.faces[k];
    const std::optional<PlaneFit> fit = fit_members(scan, sigma_mm, met, face.normal);
    if (!fit) return;
    face.normal = fit->normal;
    face.d_mm = fit->d_mm;
    face.points = fit->points;
    face.point_mm -= fit->normal * (fit->normal.dot(face.point_mm) - fit->d_mm);
    face.covariance = covariance_at(*fit, face.point_mm);
    face.covariance->matrix *= std::pow(noise_scale(*fit), 2);
  });
  return list;
}

}  // namespace tetragauge
