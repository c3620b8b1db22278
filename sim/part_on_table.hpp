// SPDX-License-Identifier: GPL-3.0-or-later
// The part as it stands on the rotary table, in the part frame (fixed to the table, z up, origin on the axis
// at the table top), and what light meets there.
#pragma once

#include <optional>

#include "host/base/result.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge::sim {

// Largest part the machine takes: it stands within this box on the table.
inline constexpr double kVolumeSide_mm = 100, kVolumeHeight_mm = 200;

// Turned by R of `place`, stood with the centre of its bounding box on the axis and its lowest point on the
// table, then shifted by t of `place`. Error (bad input): it then reaches out of the working volume; `name`
// is the part's file.
Result<Solid> stand_on_table(const Solid& model, const RigidTransform& place, const std::string& name);

struct SurfaceHit {
  double distance_mm = 0;
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  double albedo = 0;
};

// A disc about the origin.
struct TableTop {
  Vec3 normal = Vec3::UnitZ();
  double radius_mm = 0, albedo = 0;
};

class PartOnTable {
 public:
  PartOnTable(const Solid& standing, double part_albedo, const TableTop& table);

  // What a beam meets first: part or table top. Part frame.
  std::optional<SurfaceHit> first_hit(const Vec3& origin, const Vec3& direction) const;
  // Whether a camera at `to` sees the surface at `from`.
  bool sees(const Vec3& from, const Vec3& to) const;

 private:
  RayCaster part_;
  double part_albedo_;
  TableTop table_;
};

}  // namespace tetragauge::sim
