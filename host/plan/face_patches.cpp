// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/face_patches.hpp"

#include <algorithm>
#include <cmath>

#include "host/solid/face_outline.hpp"

namespace tetragauge {
namespace {

constexpr double kPatch_mm2 = 6;                               // wanted size: some 2.5 mm across
constexpr size_t kLeast = 16, kMost = 250, kMostCorners = 24;  // of a face, of a model with few
constexpr size_t kMostInAll = 8000;
constexpr double kInside_mm =
    0.3;  // a corner's spot lies so far inside, where an edge does not cut it in two
// A triangle's chord is at most this far from the face (ReadSolidOptions::tessellation_mm), with room.
constexpr double kChord_mm = 0.05;

// The face's own surface where the triangles have `p`; false: another face lies there.
bool put_on_surface(const RayCaster& caster, const Vec3& normal_of_triangle, Patch& patch) {
  const auto hit = caster.first_hit(patch.point_mm + kChord_mm * normal_of_triangle, -normal_of_triangle);
  if (!hit || hit->face != patch.face || hit->distance_mm > 2 * kChord_mm) return false;
  patch.point_mm = hit->point_mm;
  patch.normal = hit->normal;
  return true;
}

Vec3 normal_of(const std::array<Vec3, 3>& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

void add_corners(const RayCaster& caster, const FaceOutline& outline, int face, size_t most,
                 std::vector<Patch>& patches) {
  const size_t corners = 3 * outline.triangles.size();
  const size_t stride = std::max<size_t>(1, corners / most);
  for (size_t k = 0; k < corners; k += stride) {
    const std::array<Vec3, 3>& t = outline.triangles[k / 3];
    const Vec3& corner = t[k % 3];
    const Vec3 to_middle = (t[0] + t[1] + t[2]) / 3 - corner;
    Patch patch;
    patch.point_mm = corner + to_middle * std::min(0.5, kInside_mm / std::max(1e-9, to_middle.norm()));
    patch.face = face;
    if (put_on_surface(caster, normal_of(t), patch)) patches.push_back(patch);
  }
}

}  // namespace

std::vector<Patch> face_patches(const Solid& model, const RayCaster& caster) {
  const std::vector<FaceOutline> outlines = face_outlines(model);
  const double fair = static_cast<double>(kMostInAll) / std::max(1.0, model.area_mm2 / kPatch_mm2);
  const size_t of_each = kMostInAll / std::max<size_t>(1, outlines.size());
  const size_t least = std::clamp<size_t>(of_each, 2, kLeast);
  const size_t most_corners = std::clamp<size_t>(of_each, 1, kMostCorners);
  std::vector<Patch> patches;
  for (size_t face = 0; face < outlines.size(); ++face) {
    const double area = model.faces()[face].area_mm2;
    const auto count = std::clamp(static_cast<size_t>(std::min(1.0, fair) * area / kPatch_mm2), least, kMost);
    // With their triangles, one after the other: samples_over() does not say which a sample is of.
    double owed = 0;
    std::vector<Patch> of_face;
    for (const std::array<Vec3, 3>& t : outlines[face].triangles) {
      FaceOutline one;
      one.triangles.push_back(t);
      owed +=
          static_cast<double>(count) * 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm() / std::max(1e-9, area);
      const auto here = static_cast<size_t>(owed + 0.5);
      if (here == 0) continue;
      owed -= static_cast<double>(here);
      for (const Vec3& p : samples_over(one, here)) {
        Patch patch;
        patch.point_mm = p;
        patch.face = static_cast<int>(face);
        if (put_on_surface(caster, normal_of(t), patch)) of_face.push_back(patch);
      }
    }
    for (Patch& patch : of_face) {
      patch.area_mm2 = area / static_cast<double>(of_face.size());
      patch.reach_mm = 0.5 * std::sqrt(patch.area_mm2);
    }
    patches.insert(patches.end(), of_face.begin(), of_face.end());
    add_corners(caster, outlines[face], static_cast<int>(face), most_corners, patches);
  }
  return patches;
}

}  // namespace tetragauge
