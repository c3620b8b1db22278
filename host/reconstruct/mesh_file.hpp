// SPDX-License-Identifier: GPL-3.0-or-later
// The reconstructed surface as PLY (binary little-endian): vertices (double, mm, part frame), triangles with
// `confidence` (0..1) and `unseen` (1: no ray touched it) per face. Opens in CloudCompare and MeshLab.
#pragma once

#include <string>

#include "host/reconstruct/reconstruct.hpp"

namespace tetragauge {

std::string surface_to_ply(const Reconstruction& reconstruction);

}  // namespace tetragauge
