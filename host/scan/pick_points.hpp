// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "host/scan/scan.hpp"

namespace tetragauge {

// A scan of these points of another, in this order, under its header. Beams without a point are left out.
Scan pick_points(const Scan& scan, std::span<const uint32_t> points);

}  // namespace tetragauge
