// SPDX-License-Identifier: GPL-3.0-or-later
// From points with rays to the surface between solid and air (DESIGN section 5, "Reconstruct").
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/base/result.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge {

enum class ReconstructMethod { cut, carve };

struct ReconstructOptions {
  ReconstructMethod method = ReconstructMethod::cut;
  double spacing_mm = 0;  // wanted spacing of the averaged vertices; 0: from point spacing and sigma
  const RayCaster* model =
      nullptr;                   // carve: the thesis's second elimination shoots into it; in the scan's frame
  bool keep_tetrahedra = false;  // Reconstruction::cells
};

struct SurfaceTriangle {
  std::array<uint32_t, 3> vertex;    // counter-clockwise seen from the air
  std::array<int32_t, 3> neighbour;  // triangle across the edge opposite vertex i
  float confidence = 0;              // 0..1
  bool unseen = false;               // no ray touched it: closes the solid, never a face
};

// One that another measurement should decide: see rank_doubtful.hpp.
struct DoubtfulTetrahedron {
  Vec3 centroid_mm = Vec3::Zero();
  double volume_mm3 = 0;
  double face_area_mm2 = 0;       // of its facets that are surface
  Vec3 look_from = Vec3::Zero();  // unit: a ray from there, to the centroid, would decide it
  float confidence = 0;           // 0..1, of its label
  bool is_air = false;
  uint32_t cell = 0;  // index into Reconstruction::cells
};

struct LabelledTetrahedron {
  std::array<uint32_t, 4> vertex;  // positively oriented
  bool is_air = false, is_doubtful = false;
  float confidence = 0;                // 0..1; 0 where rays are silent
  float air_rays = 0, solid_rays = 0;  // votes, in rays of typical sigma
};

struct Reconstruction {
  std::vector<Vec3> vertices;          // averaged points, mm, part frame
  std::vector<float> vertex_sigma_mm;  // of the averaged vertex, along its mean ray
  std::vector<Vec3> vertex_ray;        // unit, mean direction the light travelled
  std::vector<uint32_t> point_vertex;  // for each raw point its vertex
  std::vector<SurfaceTriangle> surface;
  double vertex_spacing_mm = 0;  // of the averaged vertices
  double point_spacing_mm = 0;   // of the raw points on the surface

  std::vector<DoubtfulTetrahedron> doubtful_ranked;  // largest volume first
  std::vector<LabelledTetrahedron> cells;            // with keep_tetrahedra

  size_t tetrahedra = 0, air = 0, solid = 0, doubtful = 0;
  size_t rays_walked = 0, rays_lost = 0;
  bool closed = false;
  double volume_mm3 = 0, area_mm2 = 0;  // of the solid tetrahedra; area of the seen surface
  Vec3 centroid_mm = Vec3::Zero();
  Mat3 inertia_mm5 = Mat3::Zero();  // about the centroid, density 1
};

// Errors: fewer than 4 points, all points in one plane (names what to do).
Result<Reconstruction> reconstruct(const Scan& scan, const ReconstructOptions& options = {});

}  // namespace tetragauge
