// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/pair_planes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetragauge {
namespace {

// How far apart the centroids of a model face and of a measured patch on it may be. If the patch is the share
// f of the face, at most (1 - f) of the part's size: the whole is the weighted mean of the patch and the
// rest. Without knowing the faces' outlines no more can be said.
double most_apart(const MatchPlane& face, const MatchPlane& seen, double size_mm) {
  const double share = seen.area_mm2 / (kAreaSlack * face.area_mm2);
  if (share > 1) return 1e300;     // it covers other faces of the plane too
  return (1.1 - share) * size_mm;  // a tenth for patches seen in part, whose centroid is uncertain
}

// A measured face with more than this multiple of all the model's area on the plane is another thing: the
// table under the part, or a part in another unit.
constexpr double kMostArea = 2;

// Projector onto the directions in which the measured planes say where the part is; where they leave it free
// a centroid tells nothing. With one line of normals the spin is free too, and nothing is left.
Mat3 bounded_directions(const PlaneSet& measured, const RigidTransform& T) {
  Mat3 spread = Mat3::Zero();
  for (const MatchPlane& seen : measured.planes) {
    const Vec3 normal = T.R * seen.normal;
    spread += normal * normal.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(spread);
  if (eigen.eigenvalues()[1] < 0.01) return Mat3::Zero();
  Mat3 projector = Mat3::Identity();
  const Vec3 free = eigen.eigenvectors().col(0);
  if (eigen.eigenvalues()[0] < 0.01) projector -= free * free.transpose();
  return projector;
}

// Those whose direction is within the gate, or may be: the mean of a direction is no farther from its faces'
// normals than twice the angle they share.
std::vector<size_t> planes_near(const PlaneSet& model, const Vec3& normal, const SearchGates& gates) {
  const double least_cosine =
      std::cos(std::min(std::numbers::pi, kFixedGates * gates.angle_rad + 2 * model.direction_rad));
  std::vector<size_t> near;
  for (size_t k = 0; k < model.directions.size(); ++k) {
    const double cosine = model.directions[k].normal.dot(normal);
    if ((gates.is_unsigned ? std::abs(cosine) : cosine) >= least_cosine)
      near.insert(near.end(), model.planes_along[k].begin(), model.planes_along[k].end());
  }
  std::sort(near.begin(), near.end());
  return near;
}

struct Fit {
  PlanePair pair;
  double offset_mm = 0;
  Vec3 normal = Vec3::Zero();  // measured, in the model frame, out of the material
  double tilt_rad = 0;         // its own standard uncertainty
  double misfit = 0;           // of offset and direction, in gates, squared; 2 at most
};

double tilt_sigma(const MatchPlane& plane) {
  return std::sqrt(std::max(plane.covariance.matrix(1, 1), plane.covariance.matrix(2, 2)));
}

bool is_fragment(const Fit& fit, const Fit& best, const FragmentLimits& limits) {
  const double turn = fit.normal.cross(best.normal).norm();
  return std::abs(fit.offset_mm - best.offset_mm) <= limits.offset_mm &&
         turn <= std::max(limits.angle_rad, 4 * std::hypot(fit.tilt_rad, best.tilt_rad));
}

}  // namespace

std::vector<PlanePair> pair_planes(const PlaneSet& model, const PlaneSet& measured, const RigidTransform& T,
                                   const SearchGates& gates, const FragmentLimits& fragment) {
  std::vector<Fit> fits;
  const double least_cosine = std::cos(gates.angle_rad);
  const Mat3 bounded = bounded_directions(measured, T);
  const bool areas_known = model.has_areas && measured.has_areas;
  const bool located = areas_known && model.has_centroids && measured.has_centroids;
  for (size_t j = 0; j < measured.planes.size(); ++j) {
    const Vec3 point = T * measured.planes[j].point_mm;
    const Vec3 normal = T.R * measured.planes[j].normal;
    Fit best;
    double least_misfit = 3, best_distance = 0;  // least_misfit: that of the centroids too
    int best_group = -1;
    for (const size_t i : planes_near(model, normal, gates)) {
      const MatchPlane& face = model.planes[i];
      if (!gates.allowed(i, j)) continue;
      const double cosine = face.normal.dot(normal);
      const bool flipped = gates.is_unsigned && cosine < 0;
      if (gates.allowed.is_fixed(i, j)) {  // not asked further
        best = {{i, j, flipped}, 0, flipped ? Vec3(-normal) : normal, 0, 0};
        best_group = face.group;
        break;
      }
      if ((flipped ? -cosine : cosine) < least_cosine) continue;
      if (areas_known &&
          measured.planes[j].area_mm2 > kMostArea * model.group_area_mm2[static_cast<size_t>(face.group)])
        continue;
      const double offset = face.normal.dot(point) - face.d_mm;
      if (std::abs(offset) > gates.offset_mm) continue;
      const double turn = face.normal.cross(normal).norm() / gates.angle_rad;
      const double misfit = std::pow(offset / gates.offset_mm, 2) + turn * turn;
      const double distance = (point - face.point_mm).norm();
      const double apart = located ? (bounded * (point - face.point_mm)).norm() /
                                         most_apart(face, measured.planes[j], model.size_mm)
                                   : 0;
      if (apart > 1) continue;
      // On a ladder of planes closer than the gate the centroid tells the rungs apart.
      const double with_centroid = misfit + apart * apart;
      const bool same_plane = face.group == best_group;
      const bool nearer = model.has_centroids && measured.has_centroids && distance < best_distance;
      if (same_plane ? nearer : with_centroid < least_misfit) {
        best = {{i, j, flipped},
                offset,
                flipped ? Vec3(-normal) : normal,
                tilt_sigma(measured.planes[j]),
                misfit};
        least_misfit = with_centroid;
        best_distance = distance;
        best_group = face.group;
      }
    }
    if (best_group >= 0) fits.push_back(best);
  }
  // Of several on one model face the larger is the face, unless it fits much worse.
  const auto claim = [&](const Fit& fit) {
    return measured.planes[fit.pair.measured].area_mm2 * (1 - 0.5 * fit.misfit);
  };
  std::stable_sort(fits.begin(), fits.end(), [&](const Fit& a, const Fit& b) {
    return a.pair.model != b.pair.model ? a.pair.model < b.pair.model : claim(a) > claim(b);
  });
  std::vector<PlanePair> pairs;
  for (size_t k = 0; k < fits.size();) {
    const Fit& best = fits[k];
    const size_t first = pairs.size();
    for (; k < fits.size() && fits[k].pair.model == best.pair.model; ++k)
      if (&fits[k] == &best || gates.allowed.is_fixed(fits[k].pair.model, fits[k].pair.measured) ||
          is_fragment(fits[k], best, fragment))
        pairs.push_back(fits[k].pair);
    std::sort(pairs.begin() + static_cast<std::ptrdiff_t>(first), pairs.end(),
              [](const PlanePair& a, const PlanePair& b) { return a.measured < b.measured; });
  }
  return pairs;
}

std::vector<PlaneObservation> observations(const PlaneSet& model, const PlaneSet& measured,
                                           const std::vector<PlanePair>& pairs) {
  std::vector<PlaneObservation> out;
  out.reserve(pairs.size());
  for (const PlanePair& pair : pairs)
    out.push_back(observe(model.planes[pair.model], measured.planes[pair.measured], pair.flipped));
  return out;
}

std::vector<double> face_costs(const PlaneSet& model, const PlaneSet& measured, const RigidTransform& T,
                               const std::vector<PlanePair>& pairs, double scatter_mm, double scatter_rad) {
  double largest_mm2 = 0;
  for (const MatchPlane& seen : measured.planes) largest_mm2 = std::max(largest_mm2, seen.area_mm2);
  const auto weight = [&](double area_mm2) { return face_weight(area_mm2, largest_mm2); };

  std::vector<double> costs;
  for (const MatchPlane& seen : measured.planes) costs.push_back(kFaceCost * weight(seen.area_mm2));
  std::vector<double> on_plane_mm2(model.group_area_mm2.size(), 0.0);
  for (const PlanePair& pair : pairs) {
    const MatchPlane& seen = measured.planes[pair.measured];
    const PlaneObservation observed = observe(model.planes[pair.model], seen, pair.flipped);
    Mat3 covariance = observed.covariance.matrix;
    covariance(0, 0) += scatter_mm * scatter_mm;
    covariance(1, 1) += scatter_rad * scatter_rad;
    covariance(2, 2) += scatter_rad * scatter_rad;
    const Vec3 r = plane_residual(observed, T);
    costs[pair.measured] = std::min(kFaceCost, r.dot(covariance.ldlt().solve(r))) * weight(seen.area_mm2);
    on_plane_mm2[static_cast<size_t>(model.planes[pair.model].group)] += seen.area_mm2;
  }
  if (model.has_areas && measured.has_areas) {
    for (const PlanePair& pair : pairs) {
      const auto g = static_cast<size_t>(model.planes[pair.model].group);
      // From a quarter to a half more than the model has: what nobody would measure by chance.
      const double excess = on_plane_mm2[g] / model.group_area_mm2[g] - kAreaSlack;
      if (excess <= 0) continue;
      costs[pair.measured] += kFaceCost * std::min(1.0, excess / 0.25) * weight(on_plane_mm2[g]) *
                              measured.planes[pair.measured].area_mm2 / on_plane_mm2[g];
    }
  }
  return costs;
}

}  // namespace tetragauge
