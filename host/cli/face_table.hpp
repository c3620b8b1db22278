// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "host/geometry/face.hpp"

namespace tetragauge::cli {

// One line a face: id, surface, type, equation, area, neighbours; fits 100 columns but for long neighbour
// lists.
std::string face_table(const FaceList& list);

}  // namespace tetragauge::cli
