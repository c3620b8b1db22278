// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "host/inspect/inspect.hpp"

namespace tetragauge {

// Per model face, whether the poses hold it: no free direction moves its surface off itself. The faces of a
// turned part lie where they lie however it is turned about its axis; a hole across it does not. A plane that
// was seen feels no shift that its pose leaves free.
std::vector<bool> held_faces(const Solid& model, const std::vector<SetUp>& set_ups);

}  // namespace tetragauge
