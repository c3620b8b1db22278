// SPDX-License-Identifier: GPL-3.0-or-later
// The reconstructed surface as PLY (binary little-endian): vertices (double, mm, part frame), triangles with
// `confidence` (0..1) and `unseen` (1: no ray touched it) per face. Opens in CloudCompare and MeshLab.
#pragma once

#include <string>

#include "host/reconstruct/reconstruct.hpp"

namespace tetragauge {

std::string surface_to_ply(const Reconstruction& reconstruction);

// The same triangles as binary STL: float, mm, no confidence; normals out of the material.
std::string surface_to_stl(const Reconstruction& reconstruction);

// The tetrahedra (ReconstructOptions::keep_tetrahedra) as VTK's XML UnstructuredGrid for ParaView, and as a
// finite-element mesh (threshold `label` = 1). Per cell: `label` 0 air, 1 solid; `doubtful` 0, 1;
// `confidence`; `air_rays`, `solid_rays`: the votes, in rays of typical sigma.
std::string tetrahedra_to_vtu(const Reconstruction& reconstruction);

}  // namespace tetragauge
