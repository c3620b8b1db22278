// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/unite_patches.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/faces/compare_planes.hpp"
#include "host/reconstruct/average_points.hpp"

namespace tetragauge {
namespace {

class PatchUniter {
 public:
  PatchUniter(const Scan& scan, const Reconstruction& reconstruction, const FittedFaces& fitted)
      : scan_(scan),
        reconstruction_(reconstruction),
        fitted_(fitted),
        sigma_mm_(floored_sigma_mm(scan)),
        vertices_(fitted.fits.size()) {
    for (uint32_t v = 0; v < fitted.vertex_face.size(); ++v) {
      if (fitted.vertex_face[v] != kNoRegion)
        vertices_[static_cast<size_t>(fitted.vertex_face[v])].push_back(v);
    }
  }

  bool are_one_face(size_t f, size_t g) const {
    const PlaneFit &a = fitted_.fits[f], &b = fitted_.fits[g];
    if (vertices_[f].empty() || vertices_[g].empty() || a.normal.dot(b.normal) <= 0 ||
        plane_chi2(a, b) >= kSamePlaneChi2)
      return false;
    // Two vertices that are nearest to one another, the first from the middle of g.
    Vec3 q = b.centroid_mm, p = q;
    for (int turn = 0; turn < 4; ++turn) {
      p = nearest(f, q);
      q = nearest(g, p);
    }
    return !proven_apart(f, g, p, q) && !wall_between(f, g, p, q) && !covered_between(f, g, p, q);
  }

 private:
  Vec3 nearest(size_t f, const Vec3& to) const {
    Vec3 best = reconstruction_.vertices[vertices_[f].front()];
    for (uint32_t v : vertices_[f]) {
      if ((reconstruction_.vertices[v] - to).squaredNorm() < (best - to).squaredNorm())
        best = reconstruction_.vertices[v];
    }
    return best;
  }

  // Looks along a corridor from p to q, 3 spacings wide, for a ray that crosses the plane, whichever way: no
  // material there; or for a point that rises from it.
  bool proven_apart(size_t f, size_t g, const Vec3& p, const Vec3& q) const {
    const PlaneFit& plane = fitted_.fits[f];
    const double s = reconstruction_.vertex_spacing_mm, length = (q - p).norm();
    if (!(length > s)) return false;
    const Vec3 along = (q - p) / length, beside = plane.normal.cross(along);
    const auto speaks = [&](const Vec3& x) {
      const double t = along.dot(x - p);
      return t > 0.5 * s && t < length - 0.5 * s && std::abs(beside.dot(x - p)) < 1.5 * s &&
             !lies_beyond_edge(f, g, x);
    };
    for (uint32_t i = 0; i < scan_.size(); ++i) {
      const Vec3 ray = scan_.ray_direction(i);
      const double height = plane.normal.dot(scan_.points[i]) - plane.d_mm, cosine = plane.normal.dot(ray);
      const double noise = 3 * sigma_across(sigma_mm_[i], ray, plane.normal);
      const bool came_from_front = plane.normal.dot(scan_.ray_origins[i]) > plane.d_mm;
      if (std::abs(height) > std::max(noise, 0.5 * s) && came_from_front != (height > 0)) {
        if (speaks(scan_.points[i] - ray * (height / cosine))) return true;
      } else if (height > noise && height < 2 * s && speaks(scan_.points[i])) {
        return true;
      }
    }
    return false;
  }

  // Beside the corridor another face may end both patches, or bound them both: what lies on it or beyond it
  // says nothing about what is between them.
  bool lies_beyond_edge(size_t f, size_t g, const Vec3& x) const {
    const double margin = 0.5 * reconstruction_.vertex_spacing_mm;
    for (size_t h = 0; h < fitted_.fits.size(); ++h) {
      if (h == f || h == g) continue;
      const PlaneFit& side = fitted_.fits[h];
      const auto distance = [&](const Vec3& at) { return side.normal.dot(at) - side.d_mm; };
      const double of_f = distance(fitted_.fits[f].centroid_mm), of_g = distance(fitted_.fits[g].centroid_mm);
      if ((of_f > margin && of_g > margin && distance(x) < margin) ||
          (of_f < -margin && of_g < -margin && distance(x) > -margin))
        return true;
    }
    return false;
  }

  // A face that stands across the line from p to q, somewhere above the plane.
  struct Side {
    double at_mm;   // from p
    bool enters;    // its material lies beyond
    double low_mm;  // its lowest vertex over the plane
  };

  // Something stands between p and q: on the way one enters it through one of its faces and leaves it by the
  // next, and no ray passes below what was seen of them (that would be a bridge, not a wall).
  bool wall_between(size_t f, size_t g, const Vec3& p, const Vec3& q) const {
    const PlaneFit& plane = fitted_.fits[f];
    const double s = reconstruction_.vertex_spacing_mm, length = (q - p).norm();
    if (!(length > s)) return false;
    const Vec3 along = (q - p) / length, beside = plane.normal.cross(along);
    std::vector<Side> sides;
    for (size_t h = 0; h < vertices_.size(); ++h) {
      const double slope = fitted_.fits[h].normal.dot(along);
      if (h == f || h == g || std::abs(slope) < 0.5) continue;
      // Where the line crosses its plane, and whether the face reaches there from both sides: much of it may
      // be in the shadow of the next wall.
      Side side{-(fitted_.fits[h].normal.dot(p) - fitted_.fits[h].d_mm) / slope, slope < 0, INFINITY};
      if (!(side.at_mm > -s && side.at_mm < length + s)) continue;
      double left = INFINITY, right = -INFINITY;
      for (uint32_t v : vertices_[h]) {
        const Vec3 r = reconstruction_.vertices[v] - p;
        const double height = plane.normal.dot(r);
        if (height < 0) continue;
        side.low_mm = std::min(side.low_mm, height);
        left = std::min(left, beside.dot(r));
        right = std::max(right, beside.dot(r));
      }
      if (left < s && right > -s) sides.push_back(side);
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.at_mm < b.at_mm; });
    for (size_t k = 0; k + 1 < sides.size(); ++k) {
      const Side &in = sides[k], &out = sides[k + 1];
      if (in.enters && !out.enters &&
          !ray_passes(plane, p, along, in.at_mm, out.at_mm, std::min(in.low_mm, out.low_mm)))
        return true;
    }
    return false;
  }

  // Material was seen over the line from p to q and not over the patches themselves, and no ray passes below
  // it: a wall whose sides are in shadow, not a bridge.
  bool covered_between(size_t f, size_t g, const Vec3& p, const Vec3& q) const {
    constexpr double kUpwards = 0.5;
    const PlaneFit& plane = fitted_.fits[f];
    const double s = reconstruction_.vertex_spacing_mm, length = (q - p).norm();
    if (!(length > s)) return false;
    const Vec3 along = (q - p) / length, beside = plane.normal.cross(along);
    const auto is_over = [&](const Vec3& x, const Vec3& patch) {
      const Vec3 r = x - patch;
      return (r - plane.normal * plane.normal.dot(r)).norm() < 1.5 * s;
    };
    for (size_t h = 0; h < vertices_.size(); ++h) {
      if (h == f || h == g || fitted_.fits[h].normal.dot(plane.normal) < kUpwards) continue;
      double from_mm = INFINITY, to_mm = -INFINITY, low_mm = INFINITY;
      bool over_patch = false;
      for (uint32_t v : vertices_[h]) {
        const Vec3& x = reconstruction_.vertices[v];
        const double height = plane.normal.dot(x - p);
        if (height < s) continue;
        over_patch =
            over_patch || is_over(x, fitted_.fits[f].centroid_mm) || is_over(x, fitted_.fits[g].centroid_mm);
        const double t = along.dot(x - p);
        if (t < 0 || t > length || std::abs(beside.dot(x - p)) > 1.5 * s) continue;
        from_mm = std::min(from_mm, t);
        to_mm = std::max(to_mm, t);
        low_mm = std::min(low_mm, height);
      }
      if (!over_patch && to_mm - from_mm > s && !ray_passes(plane, p, along, from_mm, to_mm, low_mm))
        return true;
    }
    return false;
  }

  // Whether a ray crosses the curtain over the line from p, between these distances and below this height.
  bool ray_passes(const PlaneFit& plane, const Vec3& p, const Vec3& along, double from_mm, double to_mm,
                  double below_mm) const {
    const double margin = 0.5 * reconstruction_.vertex_spacing_mm;
    const Vec3 beside = plane.normal.cross(along);
    for (uint32_t i = 0; i < scan_.size(); ++i) {
      const Vec3 r = scan_.points[i] - p, ray = scan_.ray_direction(i);
      const double across = beside.dot(ray);
      if (across == 0) continue;
      const double back = beside.dot(r) / across;  // from the point back to the curtain
      if (!(back > 0) || !(back < (scan_.points[i] - scan_.ray_origins[i]).norm())) continue;
      const Vec3 crossing = r - back * ray;
      const double t = along.dot(crossing), height = plane.normal.dot(crossing);
      if (t > from_mm + margin && t < to_mm - margin && height > margin && height < below_mm - margin)
        return true;
    }
    return false;
  }

  const Scan& scan_;
  const Reconstruction& reconstruction_;
  const FittedFaces& fitted_;
  std::vector<double> sigma_mm_;
  std::vector<std::vector<uint32_t>> vertices_;
};

}  // namespace

FittedFaces unite_patches(const Scan& scan, const Reconstruction& reconstruction, FittedFaces fitted,
                          size_t min_points) {
  const size_t faces = fitted.fits.size();
  std::vector<size_t> on_its_side(faces, 0);
  for (const int32_t f : fitted.point_side) {
    if (f != kNoRegion) ++on_its_side[static_cast<size_t>(f)];
  }
  std::vector<int32_t> becomes(faces);
  std::iota(becomes.begin(), becomes.end(), 0);
  {
    const PatchUniter uniter(scan, reconstruction, fitted);
    for (size_t g = 1; g < faces; ++g) {
      if (on_its_side[g] < min_points) continue;
      for (size_t f = 0; f < g; ++f) {
        if (on_its_side[f] < min_points || becomes[f] != static_cast<int32_t>(f) ||
            !uniter.are_one_face(f, g))
          continue;
        becomes[g] = static_cast<int32_t>(f);
        break;
      }
    }
  }
  FittedFaces result;
  std::vector<int32_t> new_index(faces, kNoRegion);
  std::vector<size_t> old_index;
  for (size_t f = 0; f < faces; ++f) {
    if (becomes[f] == static_cast<int32_t>(f)) {
      new_index[f] = static_cast<int32_t>(old_index.size());
      old_index.push_back(f);
    } else {
      new_index[f] = new_index[static_cast<size_t>(becomes[f])];
    }
  }
  const auto renumber = [&](std::vector<int32_t>& labels) {
    for (int32_t& f : labels) {
      if (f != kNoRegion) f = new_index[static_cast<size_t>(f)];
    }
  };
  renumber(fitted.point_face);
  renumber(fitted.point_side);
  renumber(fitted.vertex_face);
  std::vector<std::vector<uint32_t>> members(old_index.size());
  for (uint32_t i = 0; i < scan.size(); ++i) {
    if (fitted.point_face[i] != kNoRegion) members[static_cast<size_t>(fitted.point_face[i])].push_back(i);
  }
  const std::vector<double> sigma_mm = floored_sigma_mm(scan);
  for (size_t k = 0; k < old_index.size(); ++k) {
    const PlaneFit& first = fitted.fits[old_index[k]];
    const auto together = members[k].size() == first.points
                              ? std::optional<PlaneFit>(first)
                              : fit_members(scan, sigma_mm, members[k], first.normal);
    result.fits.push_back(together.value_or(first));
  }
  result.point_face = std::move(fitted.point_face);
  result.point_side = std::move(fitted.point_side);
  result.vertex_face = std::move(fitted.vertex_face);
  return result;
}

}  // namespace tetragauge
