// SPDX-License-Identifier: Apache-2.0
// The one message that a machine sends thousands of times a minute, without a general encoder: the very bytes
// that nanopb makes of it, in a fraction of its instructions.
#pragma once

#include <cstddef>
#include <cstdint>

#include "protocol/machine.pb.h"

namespace tetragauge {

// MachineMessage{points: batch} into payload[capacity]. Returns the number of bytes, 0 when it does not fit.
size_t encode_points(const tg_PointBatch& batch, uint8_t* payload, size_t capacity);

}  // namespace tetragauge
