// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/load_plan.hpp"

#include <algorithm>
#include <string>

namespace tetragauge {

uint32_t plan_id_of(std::span<const tg_View> views) {
  uint32_t crc = 0;
  for (const tg_View& v : views) {
    const int64_t fields[] = {v.table_udeg,  v.slide_um, v.a_first_urad, v.b_first_urad, v.a_step_urad,
                              v.b_step_urad, v.columns,  v.rows,         v.samples};
    crc = crc32c(fields, sizeof fields, crc);
  }
  return std::max(crc, 1u);
}

std::vector<tg_HostMessage> load_chunks(uint32_t plan_id, std::span<const tg_View> views) {
  std::vector<tg_HostMessage> chunks;
  constexpr size_t kChunk = std::extent_v<decltype(tg_ScanLoad::views)>;
  for (size_t first = 0; first < views.size(); first += kChunk) {
    const auto part = views.subspan(first, std::min(kChunk, views.size() - first));
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_scan_load_tag;
    tg_ScanLoad& load = message.body.scan_load;
    load.plan_id = plan_id;
    load.first_view = static_cast<uint32_t>(first);
    load.total_views = static_cast<uint32_t>(views.size());
    load.views_count = static_cast<pb_size_t>(part.size());
    std::copy(part.begin(), part.end(), load.views);
    chunks.push_back(message);
  }
  return chunks;
}

Status send_chunks(Link& link, std::span<const tg_HostMessage> chunks) {
  for (const tg_HostMessage& chunk : chunks) {
    const auto reply = link.request(chunk);
    if (!reply) return reply.error();
  }
  return Done{};
}

Status load_plan(Link& link, uint32_t plan_id, std::span<const tg_View> views) {
  if (views.size() > link.machine().max_views) {
    return bad_input("the plan has " + std::to_string(views.size()) + " views, the machine takes " +
                     std::to_string(link.machine().max_views) + "; split it");
  }
  return send_chunks(link, load_chunks(plan_id, views));
}

}  // namespace tetragauge
