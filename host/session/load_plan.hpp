// SPDX-License-Identifier: GPL-3.0-or-later
// A plan's views into the machine.
#pragma once

#include <span>
#include <vector>

#include "host/link/link.hpp"

namespace tetragauge {

// The same plan has the same id, in every run.
uint32_t plan_id_of(std::span<const tg_View> views);

// The ScanLoad messages that load it, in order.
std::vector<tg_HostMessage> load_chunks(uint32_t plan_id, std::span<const tg_View> views);

Status send_chunks(Link& link, std::span<const tg_HostMessage> chunks);

// ARMED afterwards.
Status load_plan(Link& link, uint32_t plan_id, std::span<const tg_View> views);

}  // namespace tetragauge
