// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/receive_beams.hpp"

#include <algorithm>
#include <array>

#include "host/session/prepare_machine.hpp"

namespace tetragauge {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// After so long without a stream item the last credit is repeated: it or an item may have been lost.
constexpr milliseconds kQuiet{300};

Status grant(Link& link, uint32_t plan_id, uint32_t next) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_points_credit_tag;
  message.body.points_credit = {plan_id, next, next + std::max(link.machine().ring_items, 1u)};
  return link.send_event(message);
}

Status ask_again(Link& link, uint32_t plan_id, uint32_t first, uint32_t count) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_points_resend_tag;
  message.body.points_resend = {plan_id, first, count};
  return link.send_event(message);
}

class Receiver {
 public:
  Receiver(Link& link, uint32_t plan_id) : link_(link), plan_id_(plan_id) {}

  uint32_t next() const { return next_; }

  // True when the item is the next one; asks for the gap before it otherwise.
  Result<bool> accept(const StreamItem& item) {
    if (item.number == next_) {
      ++next_;
      asked_ = false;
      if (const Status done = grant(link_, plan_id_, next_); !done) return done.error();
      return true;
    }
    if (item.number > next_ && !asked_) {
      asked_ = true;  // once for each gap; a lost request is repeated when it gets quiet
      if (const Status done = ask_again(link_, plan_id_, next_, item.number - next_); !done)
        return done.error();
    }
    return false;
  }

  // Nothing came for a while.
  Status nudge() {
    asked_ = false;
    if (const Status done = grant(link_, plan_id_, next_); !done) return done;
    const auto& heartbeat = link_.heartbeat();
    if (heartbeat && heartbeat->plan_id == plan_id_ && heartbeat->stream_next > next_) {
      return ask_again(link_, plan_id_, next_, heartbeat->stream_next - next_);
    }
    return Done{};
  }

 private:
  Link& link_;
  uint32_t plan_id_;
  uint32_t next_ = 0;
  bool asked_ = false;
};

struct Sum {
  uint32_t points = 0, rejected = 0, crc = 0;

  void add(std::span<const BeamRecord> beams) {
    for (const BeamRecord& beam : beams) {
      ++(beam.reason == 0 ? points : rejected);
      crc = crc_of_beam(beam, crc);
    }
  }
};

Result<StreamEnd> check_end(const Link& link, const tg_ScanEnd& end, const Sum& sum) {
  if (end.fault != tg_FaultCode_FAULT_NONE) return link.fault_error(end.fault, "");
  if (end.aborted)
    return machine_error(link.device() + ": the scan was aborted at the machine; repeat the command");
  if (end.points != sum.points || end.rejected != sum.rejected || end.crc != sum.crc) {
    return machine_error(link.device() + ": the scan that came is not the one the machine sent (" +
                         std::to_string(sum.points) + " of " + std::to_string(end.points) +
                         " points, or the checksum differs); repeat the command");
  }
  return StreamEnd{end.clock_us};
}

// What the machine says about itself beside the stream.
Status look_after(Link& link) {
  if (link.fault()) return link.fault_error(link.fault()->code, link.fault()->detail);
  const auto& heartbeat = link.heartbeat();
  if (!heartbeat) return Done{};
  if (heartbeat->state == tg_State_STATE_FAULT || heartbeat->state == tg_State_STATE_ESTOP) {
    return link.fault_error(heartbeat->fault, "");
  }
  return Done{};
}

}  // namespace

Status grant_first_credit(Link& link, uint32_t plan_id) {
  return grant(link, plan_id, 0);
}

Result<StreamEnd> receive_beams(
    Link& link, uint32_t plan_id, const ScanOptions& options,
    const std::function<void(const tg_PointBatch&, std::span<const BeamRecord>)>& take) {
  Receiver receiver(link, plan_id);
  Sum sum;
  uint32_t resumed_at = 0;  // the last heartbeat that was answered by ScanResume
  for (;;) {
    if (options.stop && *options.stop) return machine_error(link.device() + ": stopped; the laser is off");
    if (const Status good = look_after(link); !good) return good.error();
    const auto item = link.next_stream_item(kQuiet);
    if (!item) return item.error();
    if (!*item) {
      if (link.silent_for() >= link.silence()) return link.silence_error();
      // Our own silence (a suspended computer, say) has paused it.
      const auto& heartbeat = link.heartbeat();
      if (heartbeat && heartbeat->state == tg_State_STATE_PAUSED && heartbeat->counter != resumed_at) {
        resumed_at = heartbeat->counter;
        if (const Status done = command(link, tg_HostMessage_scan_resume_tag); !done) return done.error();
      }
      if (const Status done = receiver.nudge(); !done) return done.error();
      continue;
    }
    const tg_MachineMessage& message = (*item)->message;
    // Items of an earlier plan may still be on their way.
    const bool ours =
        (message.which_body == tg_MachineMessage_points_tag && message.body.points.plan_id == plan_id) ||
        (message.which_body == tg_MachineMessage_scan_end_tag && message.body.scan_end.plan_id == plan_id);
    if (!ours) continue;
    const auto accepted = receiver.accept(**item);
    if (!accepted) return accepted.error();
    if (!*accepted) continue;
    if (message.which_body == tg_MachineMessage_scan_end_tag)
      return check_end(link, message.body.scan_end, sum);
    std::array<BeamRecord, kBatchBeams> beams;
    const uint32_t count = beams_of_batch(message.body.points, beams.data());
    if (count == 0) {
      return machine_error(link.device() +
                           ": a batch of points contradicts itself; flash firmware of this version");
    }
    const std::span<const BeamRecord> batch(beams.data(), count);
    sum.add(batch);
    take(message.body.points, batch);
  }
}

}  // namespace tetragauge
