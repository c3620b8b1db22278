// SPDX-License-Identifier: GPL-3.0-or-later
// The stream of a running scan, in order and complete: grants credit, asks again for what got lost, and at
// the end compares count and checksum with the machine's.
#pragma once

#include <functional>
#include <span>

#include "host/session/run_scan.hpp"
#include "protocol/beam_record.hpp"

namespace tetragauge {

// What has come of a stream so far.
struct StreamSum {
  uint32_t items = 0, points = 0, rejected = 0;
  uint32_t crc = 0;  // over the beams (protocol/beam_record.hpp)

  void add(std::span<const BeamRecord> beams);  // of one more item
};

struct StreamEnd {
  uint64_t clock_us = 0;  // the machine's, at the end of the scan
};

struct StreamTakers {
  // Each item, before the machine may forget it; an error ends the scan.
  std::function<Status(const tg_MachineMessage&)> keep;
  // Each batch with its beams, after that. Beams are numbered as the machine measures them.
  std::function<void(const tg_PointBatch&, std::span<const BeamRecord>)> take;
};

// From item `so_far.items` on, until ScanEnd. When asked to stop, the machine is told to abort, and what it
// has measured is fetched all the same.
Result<StreamEnd> receive_stream(Link& link, uint32_t plan_id, StreamSum so_far, const ScanOptions& options,
                                 const StreamTakers& takers);

// Items up to `acked` are safe; the machine may send as many more as it has room for.
Status grant_credit(Link& link, uint32_t plan_id, uint32_t acked);
Status ask_again(Link& link, uint32_t plan_id, uint32_t first, uint32_t count);

// Whether the item belongs to this plan's scan.
bool is_item_of(const tg_MachineMessage& message, uint32_t plan_id);

// Counts and checksum against the machine's own; an error too when the scan was aborted or a fault ended it.
Status check_end(const Link& link, const tg_ScanEnd& end, const StreamSum& sum);

}  // namespace tetragauge
