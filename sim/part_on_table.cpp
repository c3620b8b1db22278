// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/part_on_table.hpp"

#include <cmath>
#include <cstdio>

namespace tetragauge::sim {
namespace {

// Both hit and shadow rays start this far off the surface: above the tessellation's error, far below the
// spot.
constexpr double kClearance_mm = 1e-3;

std::string box_text(const Solid& solid) {
  char text[160];
  const Vec3 &low = solid.box_min_mm, &high = solid.box_max_mm;
  std::snprintf(text, sizeof text, "x %.1f..%.1f, y %.1f..%.1f, z %.1f..%.1f mm", low.x(), high.x(), low.y(),
                high.y(), low.z(), high.z());
  return text;
}

}  // namespace

Result<Solid> stand_on_table(const Solid& model, const RigidTransform& place, const std::string& name) {
  const Solid turned = transformed(model, {place.R, Vec3::Zero()});
  const Vec3 centre = 0.5 * (turned.box_min_mm + turned.box_max_mm);
  const Vec3 shift = Vec3(-centre.x(), -centre.y(), -turned.box_min_mm.z()) + place.t;
  Solid standing = transformed(turned, {Mat3::Identity(), shift});
  constexpr double kSlack_mm = 1e-6;
  const double half = 0.5 * kVolumeSide_mm + kSlack_mm;
  const Vec3 &low = standing.box_min_mm, &high = standing.box_max_mm;
  const bool fits = low.x() >= -half && low.y() >= -half && high.x() <= half && high.y() <= half &&
                    low.z() >= -kSlack_mm && high.z() <= kVolumeHeight_mm + kSlack_mm;
  if (!fits) {
    return bad_input(
        name + ": the part would stand at " + box_text(standing) +
        ", outside the working volume of 100 x 100 x 200 mm (x, y -50..50, z 0..200 on the table); turn or "
        "shift it with --place, or check the model's unit");
  }
  return standing;
}

PartOnTable::PartOnTable(const Solid& standing, double part_albedo, const TableTop& table)
    : part_(standing), part_albedo_(part_albedo), table_(table) {}

std::optional<SurfaceHit> PartOnTable::first_hit(const Vec3& origin, const Vec3& direction) const {
  std::optional<SurfaceHit> found;
  if (const auto hit = part_.first_hit(origin, direction)) {
    found = SurfaceHit{hit->distance_mm, hit->point_mm, hit->normal, part_albedo_};
  }
  const double height = table_.normal.dot(origin), sinks = -table_.normal.dot(direction);
  if (sinks > 0 && height > 0) {
    const double distance = height / sinks;
    const Vec3 at = origin + distance * direction;
    if (at.norm() <= table_.radius_mm && (!found || distance < found->distance_mm)) {
      found = SurfaceHit{distance, at, table_.normal, table_.albedo};
    }
  }
  return found;
}

bool PartOnTable::sees(const Vec3& from, const Vec3& to) const {
  return !part_.occluded(from, to, kClearance_mm);
}

}  // namespace tetragauge::sim
