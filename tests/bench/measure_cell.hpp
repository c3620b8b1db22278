// SPDX-License-Identifier: GPL-3.0-or-later
// One cell of the matrix: a part scanned with known noise, its faces found and compared with the truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/result.hpp"
#include "host/faces/find_faces.hpp"
#include "host/solid/solid.hpp"
#include "tests/bench/bench_parts.hpp"

namespace tetragauge::bench {

struct CellOptions {
  size_t points = 5000;
  double sigma_mm = 0.03;
  uint64_t seed = 1;  // of the pose and the noise
  FindFacesOptions faces;
  std::filesystem::path save_to;  // folder for the scan of a cell that misses; empty: none
};

struct Cell {
  std::string part;
  size_t points = 0;
  double sigma_mm = 0, spacing_mm = 0;  // spacing: square root of area over points
  // Faces that must be found: at least 30 points on them, at least two spacings wide.
  size_t wanted = 0, found = 0;
  size_t other_found = 0;     // true faces below that size, found all the same
  size_t invented = 0;        // faces that are no true face, or one found before
  size_t false_chamfers = 0;  // of the invented ones: their points lie on several true faces
  double worst_offset = 0;    // |offset bias| over what is allowed; above 1 is a miss
  size_t offsets_missed = 0;
  double worst_tilt_mrad = 0;
  double worst_area = 0;       // relative
  double boundary_volume = 0;  // relative error, signed, of the boundary model
  double mesh_volume = 0;      // error of the tetrahedra over what is allowed, signed
  double dark = 0;             // cells that miss: air that no view sees, as a share of the part's volume
  size_t rays_lost = 0;
  double reconstruct_s = 0, faces_s = 0;
  std::vector<std::string> notes;  // what misses, in words

  bool passes() const {
    return found == wanted && invented == 0 && offsets_missed == 0 && rays_lost == 0 &&
           boundary_volume <= 0.001 && boundary_volume >= -0.001 && mesh_volume <= 1 && mesh_volume >= -1;
  }
};

Result<Solid> solid_of(const BenchPart& part);
Result<Cell> measure_cell(const std::string& name, const Solid& solid, const CellOptions& options);

}  // namespace tetragauge::bench
