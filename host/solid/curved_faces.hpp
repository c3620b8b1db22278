// SPDX-License-Identifier: GPL-3.0-or-later
// A line against the true cylinders, cones, spheres, tori and free-form faces of a solid. Triangles miss what
// lies within a chord's height of a silhouette; here they only say which part of the surface belongs to the
// face (and where Newton's steps on a free-form one begin): a point of the surface is the face's if the
// surface's normal there meets one of its triangles. Neighbouring triangles share their edges, so that
// exactly one of them (or both, on the edge) takes a point: no leak within a face.
#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <cstdint>
#include <vector>

#include "host/solid/freeform_crossings.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

struct Crossing {
  double t = 0;  // along the ray
  uint32_t triangle = 0;
  bool is_entering = false;
  Vec3 normal = Vec3::Zero();  // outward, of a free-form face alone: the others have theirs by equation
};

class CurvedFaces {
 public:
  // Keeps a reference to `solid`, which must outlive it.
  CurvedFaces(RTCDevice device, const Solid& solid, const Vec3& centre);
  ~CurvedFaces();
  CurvedFaces(const CurvedFaces&) = delete;
  CurvedFaces& operator=(const CurvedFaces&) = delete;

  bool is_empty() const { return scene_ == nullptr; }

  // Every crossing with `start` <= t <= `end` along the unit `direction`, ascending; start lies within or
  // near the box.
  std::vector<Crossing> crossings(const Vec3& origin, const Vec3& direction, double start, double end) const;

 private:
  void add_box(uint32_t triangle, double height_mm);
  size_t first_piece() const { return triangles_.size() - pieces_.size(); }

  const Solid& solid_;
  Vec3 centre_;
  RTCScene scene_ = nullptr;
  std::vector<uint32_t> triangles_;          // of the curved faces by face, then of the free-form ones
  std::vector<FreeformPiece> pieces_;        // of these
  std::vector<std::array<float, 6>> boxes_;  // of triangles_, about centre_, the true surface within
};

}  // namespace tetragauge
