// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/free_on_surface.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "host/match/turn_text.hpp"

namespace tetragauge {
namespace {

// A direction known this well, as a share of the model's size, is determined; others are tried.
constexpr double kDetermined = 0.002;
// How far the model is moved to see whether the points notice.
constexpr double kTried[] = {0.03, 0.06, 0.1};

FreeDirection named(const Vec6& motion, const Vec3& pivot, double arm_mm) {
  FreeDirection direction;
  const Vec3 turn = motion.head<3>(), shift = motion.tail<3>();
  const bool turns = arm_mm * turn.norm() > shift.norm() * 0.3;
  direction.kind = turns ? FreeDirection::Kind::rotation : FreeDirection::Kind::translation;
  direction.axis = canonical_axis((turns ? turn : shift).normalized());
  // Points of the axis are shifted along it alone: shift + turn x (point - pivot) is parallel to turn.
  direction.point_mm = pivot;
  if (turns) direction.point_mm += turn.cross(shift) / turn.squaredNorm();
  return direction;
}

}  // namespace

SurfaceFreedom free_on_surface(const SurfaceProblem& problem, const PolishedPose& pose,
                               const SurfaceScatter& scatter, double same_cost) {
  SurfaceFreedom out;
  const double arm_mm = 0.3 * problem.size_mm;
  Vec6 unit;  // a turn is measured by its arc on the part
  unit << Vec3::Constant(1 / arm_mm), Vec3::Ones();
  const Mat6 scaled = unit.asDiagonal() * pose.information * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(scaled);
  const std::vector<double> costs = surface_costs(problem, pose.T_model_part, scatter);
  const double outlines = 1 / (problem.scan_spacing_mm * problem.scan_spacing_mm);
  Vec6 variance = Vec6::Zero();
  for (int k = 0; k < 6; ++k) {
    const Vec6 motion = unit.asDiagonal() * eigen.eigenvectors().col(k);
    variance[k] = 1 / (std::max(0.0, eigen.eigenvalues()[k]) + outlines);
    const double known = kDetermined * problem.size_mm;
    if (eigen.eigenvalues()[k] * known * known > 1) {
      variance[k] = 1 / eigen.eigenvalues()[k];
      continue;
    }
    const Vec6 held = eigen.eigenvectors().col(k).cwiseQuotient(unit);
    bool free = false;
    for (const double way : {-1.0, 1.0}) {
      RigidTransform moved = pose.T_model_part;
      double before = 0;
      bool unnoticed = true;
      for (const double share : kTried) {
        const double step = way * (share - before) * problem.size_mm;
        before = share;
        moved =
            polish_on_surface(problem, nudged(moved, step * motion, problem.pivot_mm), scatter, 800, 4, held)
                .T_model_part;
        const std::vector<double> there = surface_costs(problem, moved, scatter);
        double risen = 0, squares = 0;
        for (size_t i = 0; i < costs.size(); ++i) {
          risen += there[i] - costs[i];
          squares += (there[i] - costs[i]) * (there[i] - costs[i]);
        }
        // Points at an edge come and go; they sum up to no more than that by chance.
        if (risen < same_cost + 3 * std::sqrt(squares)) continue;
        // As from a parabola through here: the direction is known that well.
        const double reach = share * problem.size_mm;
        variance[k] = std::max(variance[k], reach * reach / risen);
        unnoticed = false;
        break;
      }
      free = free || unnoticed;
    }
    if (!free) continue;
    variance[k] = 0;
    out.undetermined.push_back(named(motion, problem.pivot_mm, arm_mm));
  }
  out.covariance = unit.asDiagonal() *
                   (eigen.eigenvectors() * variance.asDiagonal() * eigen.eigenvectors().transpose()) *
                   unit.asDiagonal();
  return out;
}

PoseDifference apart_but_for(const RigidTransform& a, const RigidTransform& b, const Vec3& part_middle,
                             const std::vector<FreeDirection>& free) {
  const RigidTransform motion = a * b.inverse();
  PoseDifference out{rotation_angle(motion.R), (a * part_middle - b * part_middle).norm()};
  std::vector<const FreeDirection*> turns;
  Vec3 at = b * part_middle;
  for (const FreeDirection& f : free)
    if (f.kind == FreeDirection::Kind::rotation) turns.push_back(&f);
  if (turns.size() == 1) {
    const Vec3& axis = turns[0]->axis;
    out.turn_rad = std::acos(std::clamp((motion.R * axis).dot(axis), -1.0, 1.0));
  }
  if (turns.size() > 1) out.turn_rad = 0;
  if (!turns.empty()) at = turns[0]->point_mm;
  Vec3 shift = motion * at - at;
  for (const FreeDirection& f : free)
    if (f.kind == FreeDirection::Kind::translation) shift -= f.axis * f.axis.dot(shift);
  out.shift_mm = shift.norm();
  return out;
}

}  // namespace tetragauge
