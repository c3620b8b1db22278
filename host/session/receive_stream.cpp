// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/receive_stream.hpp"

#include <algorithm>
#include <array>

#include "host/session/prepare_machine.hpp"
#include "host/session/show_machine_log.hpp"

namespace tetragauge {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// After so long without a stream item the last credit is repeated: it or an item may have been lost. An
// emulated machine's time stands still until the host has answered, so there a shorter wait tells as much.
milliseconds quiet_of(const tg_HelloReply& machine) {
  return milliseconds((machine.capabilities & tg_Capability_CAPABILITY_EMULATED) != 0 ? 100 : 300);
}

class Receiver {
 public:
  Receiver(Link& link, uint32_t plan_id, uint32_t next) : link_(link), plan_id_(plan_id), next_(next) {}

  bool is_next(const StreamItem& item) const { return item.number == next_; }

  // The next item is safe with us.
  Status accept() {
    ++next_;
    asked_ = false;
    return grant_credit(link_, plan_id_, next_);
  }

  // An item that is not the next one: the gap before it is asked for, once; a lost request is repeated when
  // it gets quiet.
  Status out_of_order(const StreamItem& item) {
    if (item.number < next_ || asked_) return Done{};
    asked_ = true;
    return ask_again(link_, plan_id_, next_, item.number - next_);
  }

  // Nothing came for a while, or something broken. What the machine has not sent yet it does not send again.
  Status nudge() {
    asked_ = false;
    if (const Status done = grant_credit(link_, plan_id_, next_); !done) return done;
    uint32_t missing = 1;
    const auto& heartbeat = link_.heartbeat();
    if (heartbeat && heartbeat->plan_id == plan_id_ && heartbeat->stream_next > next_)
      missing = heartbeat->stream_next - next_;
    return ask_again(link_, plan_id_, next_, missing);
  }

 private:
  Link& link_;
  uint32_t plan_id_;
  uint32_t next_;
  bool asked_ = false;
};

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

Error stopped(const Link& link) {
  return machine_error(link.device() + ": stopped; the laser is off");
}

}  // namespace

void StreamSum::add(std::span<const BeamRecord> beams) {
  ++items;
  for (const BeamRecord& beam : beams) {
    ++(beam.reason == 0 ? points : rejected);
    crc = crc_of_beam(beam, crc);
  }
}

Status grant_credit(Link& link, uint32_t plan_id, uint32_t acked) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_points_credit_tag;
  message.body.points_credit = {plan_id, acked, acked + std::max(link.machine().ring_items, 1u)};
  return link.send_event(message);
}

Status ask_again(Link& link, uint32_t plan_id, uint32_t first, uint32_t count) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_points_resend_tag;
  message.body.points_resend = {plan_id, first, count};
  return link.send_event(message);
}

bool is_item_of(const tg_MachineMessage& message, uint32_t plan_id) {
  switch (message.which_body) {
    case tg_MachineMessage_points_tag:
      return message.body.points.plan_id == plan_id;
    case tg_MachineMessage_scan_end_tag:
      return message.body.scan_end.plan_id == plan_id;
    default:
      return false;
  }
}

Status check_end(const Link& link, const tg_ScanEnd& end, const StreamSum& sum) {
  if (end.fault != tg_FaultCode_FAULT_NONE) return link.fault_error(end.fault, "");
  if (end.aborted)
    return machine_error(link.device() + ": the scan was aborted at the machine; repeat the command");
  if (end.points != sum.points || end.rejected != sum.rejected || end.crc != sum.crc) {
    return machine_error(link.device() + ": the scan that came is not the one the machine sent (" +
                         std::to_string(sum.points) + " of " + std::to_string(end.points) +
                         " points, or the checksum differs); scan anew");
  }
  return Done{};
}

Result<StreamEnd> receive_stream(Link& link, uint32_t plan_id, StreamSum sum, const ScanOptions& options,
                                 const StreamTakers& takers) {
  Receiver receiver(link, plan_id, sum.items);
  uint32_t resumed_at = 0;  // the last heartbeat that was answered by ScanResume
  std::optional<steady_clock::time_point> stopping_since;
  for (;;) {
    if (options.stop && *options.stop && !stopping_since) {
      if (const Status done = command(link, tg_HostMessage_scan_abort_tag); !done) return done.error();
      stopping_since = steady_clock::now();
    }
    if (stopping_since && steady_clock::now() - *stopping_since >= link.silence()) return stopped(link);
    if (const Status good = look_after(link); !good) return good.error();
    show_machine_log(link, options);
    const auto item = link.next_stream_item(quiet_of(link.machine()));
    if (!item) return item.error();
    if (!*item) {
      if (link.silent_for() >= link.silence()) return link.silence_error();
      // Our own silence (a suspended computer, say) has paused it.
      const auto& heartbeat = link.heartbeat();
      if (heartbeat && heartbeat->state == tg_State_STATE_PAUSED && heartbeat->counter != resumed_at &&
          !stopping_since) {
        resumed_at = heartbeat->counter;
        if (options.log) options.log("the machine had paused, for nobody answered it: goes on");
        if (const Status done = command(link, tg_HostMessage_scan_resume_tag); !done) return done.error();
      }
      if (const Status done = receiver.nudge(); !done) return done.error();
      continue;
    }
    const tg_MachineMessage& message = (*item)->message;
    // Items of an earlier plan may still be on their way.
    if (!is_item_of(message, plan_id)) continue;
    if (!receiver.is_next(**item)) {
      if (const Status done = receiver.out_of_order(**item); !done) return done.error();
      continue;
    }
    std::array<BeamRecord, kBatchBeams> beams;
    uint32_t count = 0;
    if (message.which_body == tg_MachineMessage_points_tag) {
      count = beams_of_batch(message.body.points, beams.data());
      if (count == 0) {
        return machine_error(link.device() +
                             ": a batch of points contradicts itself; flash firmware of this version");
      }
    }
    if (takers.keep) {
      if (const Status kept = takers.keep(message); !kept) return kept.error();
    }
    if (const Status done = receiver.accept(); !done) return done.error();
    if (message.which_body == tg_MachineMessage_scan_end_tag) {
      if (stopping_since) return stopped(link);
      if (const Status good = check_end(link, message.body.scan_end, sum); !good) return good.error();
      return StreamEnd{message.body.scan_end.clock_us};
    }
    const std::span<const BeamRecord> batch(beams.data(), count);
    sum.add(batch);
    takers.take(message.body.points, batch);
  }
}

}  // namespace tetragauge
