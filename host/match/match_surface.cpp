// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/match_surface.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/match/fit_surface.hpp"
#include "host/match/free_on_surface.hpp"
#include "host/match/polish_on_surface.hpp"
#include "host/match/rank_poses.hpp"
#include "host/match/search_surface.hpp"
#include "host/match/turn_text.hpp"

namespace tetragauge {
namespace {

constexpr size_t kPolished = 48;         // of the poses found
constexpr size_t kPolishPoints = 1500;   // to choose among them
constexpr size_t kFinalPoints = 30000;   // of the chosen one
constexpr double kAlike_rad = 0.07;      // 4 degrees: one minimum found twice
constexpr double kAlike = 0.015;         // of the model's size
constexpr double kHopeless = 2;          // times the best one's cost
constexpr double kExplained = 3;         // in standard deviations of the points about the surface
constexpr double kLeastOnSurface = 0.6;  // of the points, within the gate

struct Candidate {
  RigidTransform T_model_part;
  double cost = 0;
  bool is_known = false;
};

std::string why_equivalent(const RigidTransform& other, const RigidTransform& chosen, double more) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), ", misfit differs by %.1f (%.0f would decide)", more, kSameCost);
  return "the points on its surface do not tell it apart: " + turn_text((other * chosen.inverse()).R) +
         text.data();
}

double share_within(const std::vector<RayResidual>& residuals, double limit_mm) {
  const auto near = std::count_if(residuals.begin(), residuals.end(), [&](const RayResidual& r) {
    return r.near && std::abs(r.offset_mm) < limit_mm;
  });
  return residuals.empty() ? 0 : static_cast<double>(near) / static_cast<double>(residuals.size());
}

// Pairs between planes in the pose found, by the gates of the match by planes.
void pair_by_pose(const FaceList& model_list, const FaceList& measured_list, const MatchOptions& options,
                  Match& match) {
  const PlaneSet model = plane_set(model_list, kModelDirection_rad);
  const PlaneSet measured = plane_set(measured_list, kDefaultMaxAngle_rad / 4);
  SearchGates gates;
  gates.offset_mm = options.max_offset_mm;
  gates.angle_rad = options.max_angle_rad > 0 ? options.max_angle_rad : kDefaultMaxAngle_rad;
  gates.is_unsigned = options.is_unsigned;
  const std::vector<PlanePair> pairs =
      pair_planes(model, measured, match.T_model_part, gates, {gates.offset_mm, gates.angle_rad});
  write_pairs(model, measured, pairs, std::vector<bool>(pairs.size(), false), match);
}

}  // namespace

Result<SurfaceMatch> match_surface(const Solid& model, const RayCaster& caster, const Scan& scan,
                                   const FaceList& measured, const MatchOptions& options,
                                   const std::vector<RigidTransform>& known) {
  const SurfaceProblem problem = surface_problem(model, caster, scan);
  std::vector<SurfacePose> found = search_surface(problem);
  if (found.size() > kPolished) found.resize(kPolished);
  std::vector<Candidate> candidates;
  for (const SurfacePose& pose : found) candidates.push_back({pose.T_model_part, 0, false});
  for (const RigidTransform& pose : known) candidates.push_back({pose, 0, true});
  if (candidates.empty()) return undecided_error("the model has no surface to match");

  // One scale for all, that of the pose in which most points lie near the surface; then that of the cheapest.
  std::vector<double> median(candidates.size());
  tbb::parallel_for(size_t{0}, candidates.size(), [&](size_t k) {
    median[k] = median_distance(problem, candidates[k].T_model_part, kPolishPoints);
  });
  const auto nearest = std::min_element(median.begin(), median.end()) - median.begin();
  RigidTransform best = candidates[static_cast<size_t>(nearest)].T_model_part;
  SurfaceScatter scatter;
  for (int pass = 0; pass < 2; ++pass) {
    scatter = surface_scatter(problem, ray_residuals(problem, best, kFinalPoints));
    tbb::parallel_for(size_t{0}, candidates.size(), [&](size_t k) {
      Candidate& c = candidates[k];
      c.T_model_part = polish_on_surface(problem, c.T_model_part, scatter, kPolishPoints, 8).T_model_part;
      c.cost = surface_cost(problem, c.T_model_part, scatter);
    });
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
    best = candidates.front().T_model_part;
    // The next scatter changes what all of them cost by about the same factor.
    const double most = kHopeless * candidates.front().cost + kSameCost;
    std::erase_if(candidates, [&](const Candidate& c) { return c.cost > most && !c.is_known; });
  }

  const PolishedPose near = polish_on_surface(problem, best, scatter, kFinalPoints, 6);
  const PolishedPose chosen = polish_with_faces_out(problem, near.T_model_part, scatter, kFinalPoints, 12);
  if (share_within(ray_residuals(problem, chosen.T_model_part, kPolishPoints), options.max_offset_mm) <
      kLeastOnSurface)
    return undecided_error(
        "in no pose do the scan's points lie on the model's surface; is this the part's model, and are both "
        "in "
        "the same unit?");
  const std::vector<RayResidual> residuals = ray_residuals(problem, chosen.T_model_part, kFinalPoints);
  const SurfaceFreedom freedom = free_on_surface(problem, chosen, scatter, kSameCost);

  SurfaceMatch out;
  Match& match = out.match;
  match.found_by = MatchedBy::surface;
  match.T_model_part = chosen.T_model_part;
  match.centroid_mm = model.centroid_mm;
  match.covariance = freedom.covariance;
  match.rms_mm = chosen.rms_mm;
  match.surface_fit.scatter_mm = scatter_about_surface(problem, residuals);
  match.surface_fit.explained = share_within(residuals, kExplained * match.surface_fit.scatter_mm);
  match.max_offset_mm = options.max_offset_mm;
  match.poses_compared = candidates.size();
  pair_by_pose(model.list, measured, options, match);
  match.undetermined = freedom.undetermined;

  out.cost = candidates.front().cost;
  out.start_cost = out.cost;
  for (const Candidate& c : candidates)
    if (c.is_known) {
      out.start_cost = c.cost;
      break;
    }
  Vec3 middle = Vec3::Zero();
  for (const RayPoint& point : problem.points)
    middle += point.point_mm / static_cast<double>(problem.points.size());
  std::vector<RigidTransform> kept{match.T_model_part};
  for (const Candidate& c : candidates) {
    if (c.cost >= out.cost + kSameCost) break;
    const auto alike = [&](const RigidTransform& other) {
      const PoseDifference apart = apart_but_for(c.T_model_part, other, middle, match.undetermined);
      return apart.turn_rad < kAlike_rad && apart.shift_mm < kAlike * problem.size_mm;
    };
    if (std::any_of(kept.begin(), kept.end(), alike)) continue;
    kept.push_back(c.T_model_part);
    match.equivalents.push_back({c.T_model_part,
                                 why_equivalent(c.T_model_part, match.T_model_part, c.cost - out.cost),
                                 match.undetermined});
  }
  return out;
}

}  // namespace tetragauge
