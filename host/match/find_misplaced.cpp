// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/find_misplaced.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "host/match/free_directions.hpp"

namespace tetragauge {
namespace {

// The motion must explain so much of the deviations of its faces: a tenth of their rms may remain.
constexpr double kRemainder = 0.1;
// Or what remains of each face is noise: 99.9 % of chi-square with 3 degrees of freedom.
constexpr double kChi2_3_999 = 16.27;

// A feature explains more of what is left over than chance does; false faces by the dozen agree in twos on
// hundreds of motions.
constexpr size_t kMostCandidates = 20;

struct LeftOver {
  std::set<int> model, measured;  // ids
};

LeftOver left_over(const Match& match) {
  LeftOver out{{match.unmatched_model.begin(), match.unmatched_model.end()},
               {match.unmatched_measured.begin(), match.unmatched_measured.end()}};
  for (const FacePair& pair : match.pairs) {
    if (pair.used_in_pose) continue;
    out.model.insert(pair.model);
    out.measured.insert(pair.measured);
  }
  return out;
}

FaceList only(const FaceList& list, const std::set<int>& ids) {
  FaceList out;
  for (const Face& face : list.faces)
    if (face.type == SurfaceType::plane && ids.contains(face.id)) out.faces.push_back(face);
  return out;
}

// Into the model frame by the part's pose: a feature's own pose is then its motion back to its place, and
// the nearest to none is the likeliest.
FaceList moved(FaceList list, const RigidTransform& T) {
  for (Face& face : list.faces) {
    face.normal = T.R * face.normal;
    face.d_mm += face.normal.dot(T.t);
    face.point_mm = T * face.point_mm;
    if (!face.covariance) continue;
    face.covariance->u = T.R * face.covariance->u;
    face.covariance->v = T.R * face.covariance->v;
  }
  return list;
}

MatchOptions options_for(const MatchOptions& options, const LeftOver& left, const Match& match) {
  MatchOptions out = options;
  out.max_offset_mm = match.max_offset_mm;
  const auto gone = [&](const FaceIds& pair) {
    return !left.model.contains(pair.model) || !left.measured.contains(pair.measured);
  };
  std::erase_if(out.rules.fixed, gone);
  std::erase_if(out.rules.forbidden, gone);
  return out;
}

struct Candidate {
  std::vector<PlanePair> pairs;  // that agree
  RigidTransform T;              // back to its place, model frame
  double area_mm2 = 0;
  Vec3 middle = Vec3::Zero();  // where it should be, weighted by area
};

// The pairs that a pose keeps, fitted anew from no motion at all: along what they leave free nothing moves.
Candidate candidate(const PlaneSet& model, const PlaneSet& measured, const ScatterPrior& prior,
                    const RankedPose& pose) {
  Candidate out;
  for (size_t k = 0; k < pose.pairs.size(); ++k) {
    if (!pose.pose.used[k]) continue;
    out.pairs.push_back(pose.pairs[k]);
    const MatchPlane& face = model.planes[pose.pairs[k].model];
    out.area_mm2 += face.area_mm2;
    out.middle += face.area_mm2 * face.point_mm;
  }
  if (out.pairs.empty()) return out;
  out.middle /= out.area_mm2;
  const std::vector<PlaneObservation> seen = observations(model, measured, out.pairs);
  out.T = refine_pose(seen, RigidTransform{}, out.middle, model.size_mm, prior).T_model_part;
  const auto misfit = [&](const RigidTransform& T) {
    double sum = 0;
    for (const PlaneObservation& o : seen) {
      const Vec3 r = plane_residual(o, T);
      sum += r[0] * r[0] + std::pow(0.3 * model.size_mm * std::hypot(r[1], r[2]), 2);
      if (o.model_normal.dot(T.R * o.covariance.u.cross(o.covariance.v)) < 0) sum += 1e12;  // turned over
    }
    return sum;
  };
  if (misfit(out.T) > 1.5 * misfit(pose.pose.T_model_part) + 1e-12) out.T = pose.pose.T_model_part;
  return out;
}

bool is_feature(const PlaneSet& model, const PlaneSet& measured, const Candidate& candidate,
                const RefinedPose& part, const SearchGates& gates) {
  std::vector<Vec3> normals;
  for (const PlanePair& pair : candidate.pairs) normals.push_back(model.planes[pair.model].normal);
  size_t bounded = 3;
  for (const FreeDirection& free : free_directions(normals, Vec3::Zero()))
    bounded -= free.kind == FreeDirection::Kind::translation;
  if (candidate.pairs.size() <= bounded) return false;
  double before = 0, after = 0;
  bool is_noise = true;
  for (const PlaneObservation& seen : observations(model, measured, candidate.pairs)) {
    const auto square = [&](const Vec3& r) {
      return r[0] * r[0] + std::pow(0.3 * model.size_mm, 2) * (r[1] * r[1] + r[2] * r[2]);
    };
    const Vec3 rest = plane_residual(seen, candidate.T);
    // However far a feature has gone, its shape must be right to the same measure.
    before += std::min(square(plane_residual(seen, {})), gates.offset_mm * gates.offset_mm);
    after += square(rest);
    Mat3 covariance = seen.covariance.matrix;
    covariance(0, 0) += part.scatter_mm * part.scatter_mm;
    covariance(1, 1) += part.scatter_rad * part.scatter_rad;
    covariance(2, 2) += part.scatter_rad * part.scatter_rad;
    is_noise = is_noise && rest.dot(covariance.ldlt().solve(rest)) < kChi2_3_999;
  }
  return is_noise || after < kRemainder * kRemainder * before;
}

}  // namespace

std::vector<MisplacedFeature> find_misplaced(const MatchInput& whole, const RankedPose& chosen,
                                             const Match& match) {
  std::vector<MisplacedFeature> features;
  LeftOver left = left_over(match);
  const double size_mm = whole.model.size_mm;
  for (;;) {
    const FaceList model_faces = only(whole.model_list, left.model);
    const FaceList measured_faces = moved(only(whole.measured_list, left.measured), match.T_model_part);
    if (model_faces.faces.size() < 2 || measured_faces.faces.size() < 2) break;
    const MatchOptions options = options_for(whole.options, left, match);
    Result<MatchInput> input = match_input(model_faces, measured_faces, options);
    if (!input) break;
    const PlaneSet &model = input->model, &measured = input->measured;
    input->model.size_mm = size_mm;

    // Of the poses that fit as well, the one nearest to no motion.
    Candidate best;
    for (const RankedPose& pose : rank_poses(*input, kSameCost, kMostCandidates).poses) {
      Candidate here = candidate(model, measured, input->prior, pose);
      if (here.pairs.size() < 2 || !is_feature(model, measured, here, chosen.pose, input->gates)) continue;
      const auto motion = [&](const Candidate& c) {
        return (c.T * c.middle - c.middle).norm() + 0.3 * size_mm * rotation_angle(c.T.R);
      };
      const bool larger = here.area_mm2 > 1.01 * best.area_mm2,
                 smaller = best.area_mm2 > 1.01 * here.area_mm2;
      if (best.pairs.empty() || larger || (!smaller && motion(here) < motion(best))) best = std::move(here);
    }
    if (best.pairs.empty()) break;

    MisplacedFeature feature;
    feature.T_model_part = best.T * match.T_model_part;
    const RigidTransform motion = best.T.inverse();  // from where it should be to where it is
    feature.shift_mm = motion * best.middle - best.middle;
    feature.turn_rad = rotation_angle(motion.R);
    std::vector<Vec3> normals;
    for (const PlanePair& pair : best.pairs) {
      const FaceIds ids{model.planes[pair.model].id, measured.planes[pair.measured].id};
      feature.pairs.push_back(ids);
      left.model.erase(ids.model);
      left.measured.erase(ids.measured);
      normals.push_back(model.planes[pair.model].normal);
    }
    std::sort(feature.pairs.begin(), feature.pairs.end());
    feature.undetermined = free_directions(normals, best.middle);
    features.push_back(std::move(feature));
  }
  return features;
}

}  // namespace tetragauge
