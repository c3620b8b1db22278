// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/link/link.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "host/link/explain.hpp"
#include "protocol/schema_hash.hpp"
#include "protocol/state_name.hpp"

namespace tetragauge {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kWriteTimeout{2000};
// A broken frame may have been the reply: asked again soon, but not once for each byte of a wrong device.
constexpr milliseconds kRetryAfterNoise{20};
constexpr size_t kMostLogs = 50;

// The machine answers a request whose id it has just seen with what it said then, and an earlier session may
// have ended a moment ago: ids start where the clock stands.
uint32_t first_request_id() {
  const auto now =
      std::chrono::duration_cast<std::chrono::microseconds>(steady_clock::now().time_since_epoch());
  return static_cast<uint32_t>(now.count());
}

}  // namespace

Link::Link(std::unique_ptr<Transport> transport, LinkOptions options)
    : transport_(std::move(transport)),
      reader_(*transport_),
      options_(std::move(options)),
      next_request_(first_request_id()),
      heard_(steady_clock::now()) {}

Result<std::unique_ptr<Link>> Link::connect(std::unique_ptr<Transport> transport, LinkOptions options) {
  std::unique_ptr<Link> link(new Link(std::move(transport), std::move(options)));
  if (const Status done = link->say_hello(); !done) return done.error();
  return link;
}

Status Link::say_hello() {
  // Ends whatever half a frame an earlier session left in the machine's reader.
  constexpr std::array<uint8_t, 1> kResync{0};
  if (const Status sent = transport_->write_all(kResync, kWriteTimeout); !sent) return sent.error();
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_hello_tag;
  message.body.hello = {kProtocolVersion, kSchemaHash};
  const auto reply = request(message);
  if (!reply) return reply.error();
  if (reply->which_body != tg_MachineMessage_hello_reply_tag) {
    return machine_error(device() +
                         ": the machine's first answer is not a greeting; flash firmware of this version");
  }
  hello_ = reply->body.hello_reply;
  if (const std::string mismatch = explain_mismatch(hello_); !mismatch.empty()) {
    return machine_error(device() + ": " + mismatch);
  }
  return Done{};
}

Status Link::send(FrameHeader header, const tg_HostMessage& message) {
  std::array<uint8_t, kFrameWireBytes> wire;
  const size_t bytes = encode_message(header, message, wire.data());
  if (bytes == 0) return internal_error(device() + ": a message does not fit a frame");
  return transport_->write_all({wire.data(), bytes}, kWriteTimeout);
}

Status Link::send_event(const tg_HostMessage& message) {
  return send({Channel::kEvent, next_event_++}, message);
}

milliseconds Link::silent_for() const {
  return std::chrono::duration_cast<milliseconds>(steady_clock::now() - heard_);
}

Error Link::silence_error() const {
  const std::string seconds = std::to_string((options_.silence.count() + 500) / 1000);
  if (hello_.protocol_version != 0) {
    return machine_error(device() + ": the machine has stopped answering for " + seconds +
                         " s; check its power and cable, switch it off and on, and repeat the command");
  }
  if (reader_.bad_frames() > 0) {
    return machine_error(
        device() + ": something is there, but it does not answer in this program's protocol (" +
        std::to_string(reader_.bad_frames()) +
        " bad frames); check that this is the machine's port, and flash firmware of this version");
  }
  return machine_error(
      device() + ": no answer within " + seconds +
      " s; check that this is the machine's port, that it is powered, and that firmware is flashed");
}

Error Link::fault_error(tg_FaultCode code, const std::string& detail) const {
  std::string message = device() + ": the machine is in FAULT: " + std::string(explain_fault(code));
  if (!detail.empty()) message += " (" + detail + ")";
  return machine_error(message);
}

Status Link::take_event(const tg_MachineMessage& message) {
  switch (message.which_body) {
    case tg_MachineMessage_heartbeat_tag: {
      heartbeat_ = message.body.heartbeat;
      tg_HostMessage answer = tg_HostMessage_init_zero;
      answer.which_body = tg_HostMessage_heartbeat_ack_tag;
      answer.body.heartbeat_ack.counter = heartbeat_->counter;
      return send_event(answer);
    }
    case tg_MachineMessage_fault_tag:
      fault_ = message.body.fault;
      return Done{};
    case tg_MachineMessage_log_tag:
      if (logs_.size() == kMostLogs) logs_.pop_front();
      logs_.push_back(message.body.log);
      return Done{};
    default:
      return Done{};
  }
}

std::optional<tg_Log> Link::next_log() {
  if (logs_.empty()) return std::nullopt;
  const tg_Log oldest = logs_.front();
  logs_.pop_front();
  return oldest;
}

Status Link::take(const ReceivedMessage& received) {
  heard_ = steady_clock::now();
  switch (received.header.channel) {
    case Channel::kReply:
      // A reply that is not awaited belongs to a request that was repeated.
      if (received.header.id == awaited_) reply_ = received.message;
      return Done{};
    case Channel::kEvent:
      return take_event(received.message);
    case Channel::kStream:
      stream_.push_back({received.header.id, received.message});
      return Done{};
    case Channel::kRequest:
      return Done{};
  }
  return Done{};
}

Result<bool> Link::wait_for_frame(milliseconds timeout) {
  const auto received = reader_.next(timeout);
  if (!received) return received.error();
  if (!*received) return false;
  if (const Status done = take(**received); !done) return done.error();
  return true;
}

Result<tg_MachineMessage> Link::request(const tg_HostMessage& message) {
  awaited_ = next_request_++;
  reply_.reset();
  const auto started = steady_clock::now();
  auto sent_at = started - options_.retry;
  uint32_t bad_frames = reader_.bad_frames();
  while (!reply_) {
    const auto now = steady_clock::now();
    if (now - started >= options_.silence) return silence_error();
    const bool maybe_lost = reader_.bad_frames() != bad_frames;
    if (now - sent_at >= (maybe_lost ? kRetryAfterNoise : options_.retry)) {
      if (const Status sent = send({Channel::kRequest, awaited_}, message); !sent) return sent.error();
      sent_at = now;
      bad_frames = reader_.bad_frames();
    }
    const auto heard = wait_for_frame(maybe_lost ? kRetryAfterNoise : options_.retry);
    if (!heard) return heard.error();
  }
  awaited_ = 0;
  if (reply_->which_body == tg_MachineMessage_refused_tag) {
    const tg_Refused& refused = reply_->body.refused;
    return machine_error(device() + ": the machine refuses (state " + state_name(refused.state) +
                         "): " + refused.detail);
  }
  return *reply_;
}

Result<tg_Status> Link::status() {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_get_status_tag;
  const auto reply = request(message);
  if (!reply) return reply.error();
  if (reply->which_body != tg_MachineMessage_status_tag) {
    return machine_error(device() +
                         ": the answer to GetStatus is not a status; flash firmware of this version");
  }
  return reply->body.status;
}

Result<tg_Config> Link::config(tg_ConfigPart part) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_get_config_tag;
  message.body.get_config.part = part;
  const auto reply = request(message);
  if (!reply) return reply.error();
  if (reply->which_body != tg_MachineMessage_config_tag) {
    return machine_error(device() +
                         ": the answer to GetConfig is no configuration; flash firmware of this version");
  }
  return reply->body.config;
}

Result<std::optional<StreamItem>> Link::next_stream_item(milliseconds timeout) {
  const auto deadline = steady_clock::now() + timeout;
  while (stream_.empty()) {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now());
    if (left.count() <= 0) return std::optional<StreamItem>();
    const auto heard = wait_for_frame(left);
    if (!heard) return heard.error();
    if (!*heard) return std::optional<StreamItem>();
  }
  std::optional<StreamItem> item(stream_.front());
  stream_.pop_front();
  return item;
}

}  // namespace tetragauge
