// SPDX-License-Identifier: GPL-3.0-or-later
// Brings a machine from whatever state it is in to READY or ARMED, homed and with nothing left of an earlier
// scan.
#pragma once

#include "host/session/head_geometry.hpp"
#include "host/session/run_scan.hpp"

namespace tetragauge {

Status prepare_machine(Link& link, const ScanOptions& options);

// For head_geometry().
struct HeadConfig {
  tg_GalvoConfig galvo;
  tg_StageConfig stage;
};
Result<HeadConfig> read_head_config(Link& link);

// A request whose answer is just yes (or an error).
Status command(Link& link, pb_size_t which);

}  // namespace tetragauge
