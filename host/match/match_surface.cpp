// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/match_surface.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/match/faces_out.hpp"
#include "host/match/fit_surface.hpp"
#include "host/match/rank_poses.hpp"
#include "host/match/search_surface.hpp"
#include "host/match/surface_rivals.hpp"
#include "host/match/turn_text.hpp"

namespace tetragauge {
namespace {

constexpr size_t kPolished = 48;         // of the poses found
constexpr size_t kPolishPoints = 1500;   // to choose among them
constexpr size_t kFinalPoints = 30000;   // of the chosen one
constexpr double kHopeless = 2;          // times the best one's cost
constexpr double kExplained = 3;         // in standard deviations of the points about the surface
constexpr double kFarOff = 4;            // in scatters of the fit: a ray that speaks against the pose
constexpr double kLeastOnSurface = 0.6;  // of the points, within the gate

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

// All poses made as good as they can be point by point, cheapest first, and the scatter that this was done
// with: one scale for all, that of the pose in which most points lie near the surface, then that of the
// cheapest.
SurfaceScatter polish_all(const SurfaceProblem& problem, std::vector<NearbyPose>& poses) {
  std::vector<double> median(poses.size());
  tbb::parallel_for(size_t{0}, poses.size(), [&](size_t k) {
    median[k] = median_distance(problem, poses[k].T_model_part, kPolishPoints);
  });
  const auto nearest = std::min_element(median.begin(), median.end()) - median.begin();
  RigidTransform best = poses[static_cast<size_t>(nearest)].T_model_part;
  SurfaceScatter scatter;
  for (int pass = 0; pass < 2; ++pass) {
    scatter = surface_scatter(problem, ray_residuals(problem, best, kFinalPoints));
    tbb::parallel_for(size_t{0}, poses.size(), [&](size_t k) {
      NearbyPose& pose = poses[k];
      pose.T_model_part =
          polish_on_surface(problem, pose.T_model_part, scatter, kPolishPoints, 8).T_model_part;
      pose.cost = surface_cost(problem, pose.T_model_part, scatter);
    });
    std::stable_sort(poses.begin(), poses.end(),
                     [](const NearbyPose& a, const NearbyPose& b) { return a.cost < b.cost; });
    best = poses.front().T_model_part;
    // The next scatter changes what all of them cost by about the same factor.
    const double most = kHopeless * poses.front().cost + kSameCost;
    std::erase_if(poses, [&](const NearbyPose& pose) { return pose.cost > most; });
  }
  return tightened(problem, best, scatter);
}

// The best pose, those that the points do not tell from it, and the costs of all of them as made.
struct Settled {
  SettledPose chosen;
  double cost = 0;
  std::vector<NearbyPose> rivals;
};

Settled settle(const SurfaceProblem& problem, const std::vector<NearbyPose>& poses,
               const SurfaceScatter& scatter, double most_out_mm) {
  std::vector<RigidTransform> same;
  for (const NearbyPose& pose : poses)
    if (pose.cost < poses.front().cost + kSameCost) same.push_back(pose.T_model_part);
  const auto settled_at = [&](const RigidTransform& T) {
    Settled out{settle_on_surface(problem, T, scatter, most_out_mm), 0, {}};
    out.cost = cost_as_made(problem, out.chosen.pose.T_model_part, scatter, most_out_mm);
    out.rivals = surface_rivals(problem, out.chosen, same, scatter, most_out_mm);
    return out;
  };
  const Settled first = settled_at(same.front());
  const auto better =
      std::min_element(first.rivals.begin(), first.rivals.end(),
                       [](const NearbyPose& a, const NearbyPose& b) { return a.cost < b.cost; });
  const bool is_better = better != first.rivals.end() && better->cost + kSameCost <= first.cost;
  return is_better ? settled_at(better->T_model_part) : first;
}

}  // namespace

Result<SurfaceMatch> match_surface(const Solid& model, const RayCaster& caster, const Scan& scan,
                                   const FaceList& measured, const MatchOptions& options,
                                   const std::vector<RigidTransform>& known) {
  const SurfaceProblem problem = surface_problem(model, caster, scan);
  std::vector<NearbyPose> poses;
  for (const SurfacePose& pose : search_surface(problem)) {
    if (poses.size() == kPolished) break;
    poses.push_back({pose.T_model_part, 0});
  }
  for (const RigidTransform& pose : known) poses.push_back({pose, 0});
  if (poses.empty()) return undecided_error("the model has no surface to match");
  const size_t compared = poses.size();
  const SurfaceScatter scatter = polish_all(problem, poses);
  const Settled settled = settle(problem, poses, scatter, options.max_offset_mm);

  const PolishedPose& chosen = settled.chosen.pose;
  const SurfaceFreedom& freedom = settled.chosen.freedom;
  if (share_within(ray_residuals(problem, chosen.T_model_part, kPolishPoints), options.max_offset_mm) <
      kLeastOnSurface)
    return undecided_error(
        "in no pose do the scan's points lie on the model's surface; is this the part's model, and are both "
        "in the same unit?");
  const std::vector<RayResidual> residuals = ray_residuals(problem, chosen.T_model_part, kFinalPoints);

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
  match.poses_compared = compared;
  pair_by_pose(model.list, measured, options, match);
  match.undetermined = freedom.undetermined;

  out.against =
      share_against(residuals, settled.chosen.scatter, kFarOff * chosen.rms_mm, options.max_offset_mm);
  for (const NearbyPose& rival : settled.rivals) {
    const double more = std::max(0.0, rival.cost - settled.cost);
    if (more < kSameCost)
      match.equivalents.push_back({rival.T_model_part,
                                   why_equivalent(rival.T_model_part, match.T_model_part, more),
                                   match.undetermined});
  }
  return out;
}

}  // namespace tetragauge
