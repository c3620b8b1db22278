// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/surface_rivals.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace tetragauge {
namespace {

constexpr double kAlike_rad = 0.07;  // 4 degrees: one minimum found twice
constexpr double kAlike = 0.015;     // of the model's size

}  // namespace

std::vector<NearbyPose> surface_rivals(const SurfaceProblem& problem, const SettledPose& chosen,
                                       const std::vector<RigidTransform>& others,
                                       const SurfaceScatter& scatter, double most_out_mm) {
  Vec3 middle = Vec3::Zero();
  for (const RayPoint& point : problem.points)
    middle += point.point_mm / static_cast<double>(problem.points.size());
  std::vector<RigidTransform> known{chosen.pose.T_model_part};
  const auto is_new = [&](const RigidTransform& T) {
    return std::none_of(known.begin(), known.end(), [&](const RigidTransform& other) {
      const PoseDifference apart = apart_but_for(T, other, middle, chosen.freedom.undetermined);
      return apart.turn_rad < kAlike_rad && apart.shift_mm < kAlike * problem.size_mm;
    });
  };
  std::vector<NearbyPose> rivals;
  for (const RigidTransform& T : others)
    if (is_new(T)) rivals.push_back({T, 0});
  tbb::parallel_for(size_t{0}, rivals.size(), [&](size_t k) {
    rivals[k] = approach_surface(problem, rivals[k].T_model_part, scatter, most_out_mm);
  });
  std::vector<NearbyPose> distinct;
  for (const NearbyPose& rival : rivals) {
    if (!is_new(rival.T_model_part)) continue;
    known.push_back(rival.T_model_part);
    distinct.push_back(rival);
  }
  return distinct;
}

}  // namespace tetragauge
