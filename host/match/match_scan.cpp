// SPDX-License-Identifier: GPL-3.0-or-later
// Poses from the lists, then what the rays know and the lists do not: where the outlines of the faces are,
// and where there was air. The fit to the measured planes is a fit to their raw points: a plane's offset,
// tilts and covariance are sufficient statistics of the points it was fitted to.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "host/match/held_by_curves.hpp"
#include "host/match/match.hpp"
#include "host/match/match_surface.hpp"
#include "host/match/planes_met.hpp"
#include "host/match/rank_poses.hpp"
#include "host/match/rule_out.hpp"
#include "host/match/score_rays.hpp"

namespace tetragauge {
namespace {

// The lists alone may prefer a wrong pose of a near-symmetric part by a small face or two.
constexpr double kLetRaysDecide = 3 * kFaceCost;

// Standard deviations that are no chance among the poses of a part.
constexpr double kNoChance = 4;

// A pose by planes that more of the rays contradict is looked at again by all points.
constexpr double kTooMuchAgainst = 0.5;
constexpr double kMostlyPlanes = 0.5;
// The share of rays that may speak against a pose by the surface: stray points, what is out of place.
constexpr double kMostAgainst = 0.25;
constexpr size_t kMostStarts = 24;
constexpr size_t kScored = 600;     // rays
constexpr double kTolerance = 0.3;  // of the gate: a ray that ends farther off contradicts a pose

// By how many standard deviations more rays contradict a pose than another. Only rays that contradict one of
// the two count (McNemar, Psychometrika 12 (1947) 153): points on no face of the part (fixture, table) and on
// features that are out of place in both say nothing about which.
double more_against(const RayScore& score, const RayScore& than) {
  double here = 0, there = 0;
  for (size_t i = 0; i < score.sampled.size(); ++i) {
    here += score.sampled[i].is_against && !than.sampled[i].is_against;
    there += !score.sampled[i].is_against && than.sampled[i].is_against;
  }
  return (here - there) / std::sqrt(here + there + 4);
}

// A measured face that has its place on the model may lie off that place within the gates: the pose counts it
// as out of place, or as large as it is wrong in size. Its points on their way to that place do not speak
// against the pose once more, or one that shares the error out among several faces would seem better.
void forgive_paired(RayScore& score, const Solid& solid, const std::vector<int>& face_of_point,
                    const MatchInput& input, const RankedPose& pose) {
  std::map<int, int> surface_of;  // by the measured face's id
  for (const PlanePair& pair : pose.pairs) {
    const auto of_model = static_cast<size_t>(input.model.planes[pair.model].id) - 1;
    surface_of[input.measured.planes[pair.measured].id] = solid.faces()[of_model].surface;
  }
  for (SampledRay& ray : score.sampled) {
    if (ray.face < 0) continue;
    const auto partner = surface_of.find(face_of_point[ray.ray]);
    if (partner != surface_of.end() &&
        partner->second == solid.faces()[static_cast<size_t>(ray.face)].surface)
      ray.is_against = false;
  }
}

// Keeps the poses that the rays contradict no more than the best, and returns the others with what rules them
// out.
std::vector<RuledOutPose> keep_what_rays_allow(std::vector<RankedPose>& poses, const MatchInput& input,
                                               const Solid& solid, const RayCaster& caster, const Scan& scan,
                                               const MeasuredFaces& faces) {
  // Small features decide by their own few rays; with many poses to compare, fewer must do.
  const size_t samples = std::clamp<size_t>(40000 / poses.size(), 300, 10000);
  std::vector<int> face_of_point(scan.size(), 0);  // id; 0: of none
  for (size_t k = 0; k < faces.face_points.size(); ++k)
    for (const uint32_t i : faces.face_points[k]) face_of_point[i] = static_cast<int>(k) + 1;
  std::vector<RayScore> scores;
  for (const RankedPose& pose : poses) {
    scores.push_back(
        score_rays(caster, scan, pose.pose.T_model_part, samples, kTolerance * input.gates.offset_mm));
    forgive_paired(scores.back(), solid, face_of_point, input, pose);
  }
  size_t best = 0;
  for (size_t k = 1; k < scores.size(); ++k)
    if (scores[k].against() < scores[best].against()) best = k;
  const RigidTransform T_best = poses[best].pose.T_model_part;
  std::vector<RankedPose> kept;
  std::vector<RuledOutPose> ruled_out;
  for (size_t k = 0; k < poses.size(); ++k) {
    poses[k].doubt = more_against(scores[k], scores[best]);
    if (poses[k].doubt <= kNoChance) {
      kept.push_back(std::move(poses[k]));
    } else if (ruled_out.size() < kMostRuledOut) {
      ruled_out.push_back(ruled_out_by_rays(poses[k].pose.T_model_part, scores[k], T_best, scores[best]));
    }
  }
  poses = std::move(kept);
  return ruled_out;
}

Result<Match> match_planes(const Solid& solid, const RayCaster& caster, const Scan& scan,
                           const MeasuredFaces& faces, const MatchOptions& known) {
  const double size_mm = (solid.box_max_mm - solid.box_min_mm).norm();
  Result<MatchInput> input = match_input(solid.list, faces.list, known);
  if (!input) return input.error();
  input->model.size_mm = size_mm;
  input->model.pivot_mm = solid.centroid_mm;
  RankedPoses ranked = rank_poses(*input, kLetRaysDecide);
  if (ranked.poses.empty()) return no_pose_error(input->model, input->measured, input->gates);
  std::vector<RuledOutPose> ruled_out;
  if (ranked.poses.size() > 1) {
    ruled_out = keep_what_rays_allow(ranked.poses, *input, solid, caster, scan, faces);
    const double limit = ranked.poses[0].cost + kSameCost;
    const auto cheap = std::find_if(ranked.poses.begin(), ranked.poses.end(),
                                    [&](const RankedPose& pose) { return pose.cost >= limit; });
    ranked.rivals.insert(ranked.rivals.begin(), std::make_move_iterator(cheap),
                         std::make_move_iterator(ranked.poses.end()));
    ranked.poses.erase(cheap, ranked.poses.end());
  }
  const FaceList met = planes_met(solid, caster, scan, faces, *input, ranked.poses);
  input->measured = *measured_planes(met);
  for (RankedPose& ranked_pose : ranked.poses)
    ranked_pose.pose =
        refine_pose(observations(input->model, input->measured, ranked_pose.pairs),
                    ranked_pose.pose.T_model_part, input->model.pivot_mm, input->model.size_mm, input->prior);
  Match match = conclude_match(*input, ranked);
  match.ruled_out.insert(match.ruled_out.begin(), ruled_out.begin(), ruled_out.end());
  if (match.ruled_out.size() > kMostRuledOut) match.ruled_out.resize(kMostRuledOut);
  return match;
}

// Points on the faces that have a partner, as a share.
double share_paired(const Scan& scan, const MeasuredFaces& faces, const Match& match) {
  size_t paired = 0;
  for (const FacePair& pair : match.pairs)
    paired += faces.face_points[static_cast<size_t>(pair.measured) - 1].size();
  return static_cast<double>(paired) / static_cast<double>(scan.size());
}

// Whether another pose is this one within the gates, moved along its free directions.
bool same_but_for_free(const RigidTransform& T_model_part, const std::vector<FreeDirection>& undetermined,
                       const Match& other, const MatchOptions& gates) {
  const Mat3 turn = other.T_model_part.R * T_model_part.R.transpose();  // model frame
  Vec3 shift = other.T_model_part * (T_model_part.inverse() * other.centroid_mm) - other.centroid_mm;
  double angle = rotation_angle(turn);
  bool spins = false;
  for (const FreeDirection& free : undetermined) {
    if (free.kind == FreeDirection::Kind::translation) {
      shift -= shift.dot(free.axis) * free.axis;
    } else {
      const Vec3 image = turn * free.axis;
      angle = std::atan2(image.cross(free.axis).norm(), image.dot(free.axis));
      spins = true;
    }
  }
  return angle < gates.max_angle_rad && (spins || shift.norm() < gates.max_offset_mm);
}

bool is_one_of(const Match& match, const Match& other, const MatchOptions& gates) {
  const auto same = [&](const auto& pose) {
    return same_but_for_free(pose.T_model_part, pose.undetermined, other, gates);
  };
  return same(match) || std::any_of(match.equivalents.begin(), match.equivalents.end(), same);
}

}  // namespace

Result<Match> match_scan(const Solid& solid, const RayCaster& caster, const Scan& scan,
                         const MeasuredFaces& faces, const MatchOptions& options) {
  const double size_mm = (solid.box_max_mm - solid.box_min_mm).norm();
  MatchOptions known = options;  // a solid knows its size and its centroid, which a list only suggests
  if (!(known.max_offset_mm > 0)) known.max_offset_mm = kDefaultMaxOffset * size_mm;
  if (!(known.max_angle_rad > 0)) known.max_angle_rad = kDefaultMaxAngle_rad;
  Result<Match> planes = match_planes(solid, caster, scan, faces, known);
  // Whoever names pairs of faces wants these, not what fits better without them.
  if (!options.rules.empty()) return planes;
  const auto score = [&](const Match& match) {
    return score_rays(caster, scan, match.T_model_part, kScored, kTolerance * known.max_offset_mm);
  };
  const RayScore by_planes = planes ? score(*planes) : RayScore{};
  const bool contradicted = static_cast<double>(by_planes.against()) >=
                            kTooMuchAgainst * static_cast<double>(by_planes.sampled.size());
  if (planes && planes->undetermined.empty() && !contradicted) return planes;

  std::vector<RigidTransform> starts;
  if (planes) {
    starts.push_back(planes->T_model_part);
    for (const EquivalentPose& other : planes->equivalents) starts.push_back(other.T_model_part);
    if (starts.size() > kMostStarts) starts.resize(kMostStarts);
  }
  Result<SurfaceMatch> surface = match_surface(solid, caster, scan, faces.list, known, starts);
  if (!surface) return planes ? std::move(planes) : Result<Match>(surface.error());
  // Some pose always fits best, also of another part. Of the right one hardly a ray is off by several times
  // the scatter that the fit itself found.
  surface->match.surface_fit.why = !planes ? "the planes found give no pose"
                                   : planes->undetermined.empty()
                                       ? "most rays contradict the pose that its planes give"
                                       : "its planes leave directions free";
  if (surface->against > kMostAgainst) return planes;
  if (!planes) return std::move(surface->match);
  // Where planes hold most of the points and are not contradicted, a direction that neither they nor curved
  // faces hold is held by edges alone, and badly: a pose in which it is named as free says more than one to
  // tenths of a millimetre.
  if (share_paired(scan, faces, *planes) > kMostlyPlanes && is_one_of(*planes, surface->match, known) &&
      !curves_hold(planes->undetermined, solid, caster, scan, surface->match.T_model_part,
                   kTolerance * known.max_offset_mm))
    return planes;
  const bool says_more = surface->match.undetermined.size() < planes->undetermined.size();
  if (says_more || more_against(by_planes, score(surface->match)) > kNoChance)
    return std::move(surface->match);
  return planes;
}

}  // namespace tetragauge
