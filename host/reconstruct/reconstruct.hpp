// SPDX-License-Identifier: GPL-3.0-or-later
// From points with rays to the surface between solid and air (DESIGN section 5, "Reconstruct").
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/base/result.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge {

enum class ReconstructMethod { cut, carve };

struct ReconstructOptions {
  ReconstructMethod method = ReconstructMethod::cut;
  double spacing_mm = 0;  // wanted spacing of the averaged vertices; 0: from point spacing and sigma
};

struct SurfaceTriangle {
  std::array<uint32_t, 3> vertex;    // counter-clockwise seen from the air
  std::array<int32_t, 3> neighbour;  // triangle across the edge opposite vertex i
  float confidence = 0;              // 0..1
  bool unseen = false;               // no ray touched it: closes the solid, never a face
};

struct Reconstruction {
  std::vector<Vec3> vertices;          // averaged points, mm, part frame
  std::vector<float> vertex_sigma_mm;  // of the averaged vertex, along its mean ray
  std::vector<Vec3> vertex_ray;        // unit, mean direction the light travelled
  std::vector<uint32_t> point_vertex;  // for each raw point its vertex
  std::vector<SurfaceTriangle> surface;
  double vertex_spacing_mm = 0;  // of the averaged vertices
  double point_spacing_mm = 0;   // of the raw points on the surface

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
