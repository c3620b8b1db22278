// SPDX-License-Identifier: GPL-3.0-or-later
// The stream of a running scan, in order and complete: grants credit, asks again for what got lost, and at
// the end compares count and checksum with the machine's.
#pragma once

#include <functional>
#include <span>

#include "host/session/run_scan.hpp"
#include "protocol/beam_record.hpp"

namespace tetragauge {

struct StreamEnd {
  uint64_t clock_us = 0;  // the machine's, at the end of the scan
};

// `take` gets each batch once, in order, with its beams.
Result<StreamEnd> receive_beams(
    Link& link, uint32_t plan_id, const ScanOptions& options,
    const std::function<void(const tg_PointBatch&, std::span<const BeamRecord>)>& take);

// Allows the machine to send from item 0 on; before ScanStart.
Status grant_first_credit(Link& link, uint32_t plan_id);

}  // namespace tetragauge
