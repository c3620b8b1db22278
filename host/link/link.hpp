// SPDX-License-Identifier: GPL-3.0-or-later
// The host's end of the line to a machine: frames, requests with ids and retries, events, and the stream of
// points.
//
//   auto transport = open_transport("/dev/ttyUSB0");
//   auto link = Link::connect(std::move(*transport));  // says Hello, checks that both speak one protocol
//   auto reply = (*link)->request(message);            // repeated until answered; a refusal is an error
//
// Every failure is ErrorKind::machine, names the device and says what to do next. A thread of its own reads
// the line; heartbeats are answered by whoever calls, whenever a function here waits.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "host/base/result.hpp"
#include "host/link/line_reader.hpp"
#include "host/link/transport.hpp"

namespace tetragauge {

struct LinkOptions {
  // A machine that says nothing for so long does not answer; it sends a heartbeat every 100 ms.
  std::chrono::milliseconds silence{3000};
  // A request without reply is sent again after so long; repeating is safe (protocol/README.md).
  std::chrono::milliseconds retry{500};
};

struct StreamItem {
  uint32_t number = 0;  // within the scan
  tg_MachineMessage message = tg_MachineMessage_init_zero;
};

class Link {
 public:
  static Result<std::unique_ptr<Link>> connect(std::unique_ptr<Transport> transport,
                                               LinkOptions options = {});

  const tg_HelloReply& machine() const { return hello_; }
  const std::string& device() const { return transport_->device(); }
  std::chrono::milliseconds silence() const { return options_.silence; }

  // Sends until the reply comes. Refused is an error that carries the machine's words.
  Result<tg_MachineMessage> request(const tg_HostMessage& message);
  Result<tg_Status> status();
  Result<tg_Config> config(tg_ConfigPart part);

  // A message without reply: credit or resend.
  Status send_event(const tg_HostMessage& message);

  // The next stream item, in whatever order they come; nullopt when none came within `timeout`, or when a
  // broken frame came, which may have been one.
  Result<std::optional<StreamItem>> next_stream_item(std::chrono::milliseconds timeout);
  // Answers heartbeats until one frame of any kind came or `timeout` is over; true: a good one came.
  Result<bool> wait_for_frame(std::chrono::milliseconds timeout);

  // The last heartbeat, and a fault the machine has reported since connect().
  const std::optional<tg_Heartbeat>& heartbeat() const { return heartbeat_; }
  const std::optional<tg_Fault>& fault() const { return fault_; }
  void forget_fault() { fault_.reset(); }
  // The oldest line the machine has logged that was not taken yet. A few dozen wait, newer ones push them
  // out.
  std::optional<tg_Log> next_log();
  // Broken frames that were dropped.
  uint32_t bad_frames() const { return reader_.bad_frames(); }
  // Time since anything good was heard.
  std::chrono::milliseconds silent_for() const;
  Error silence_error() const;
  Error fault_error(tg_FaultCode code, const std::string& detail) const;

 private:
  Link(std::unique_ptr<Transport> transport, LinkOptions options);
  Status say_hello();
  Status send(FrameHeader header, const tg_HostMessage& message);
  Status take(const ReceivedMessage& received);
  Status take_event(const tg_MachineMessage& message);

  std::unique_ptr<Transport> transport_;
  LineReader reader_;
  LinkOptions options_;
  tg_HelloReply hello_ = tg_HelloReply_init_zero;
  uint32_t next_request_, next_event_ = 1;
  uint32_t awaited_ = 0;  // id of the request that waits for its reply; 0: none
  std::optional<tg_MachineMessage> reply_;
  std::deque<StreamItem> stream_;
  std::optional<tg_Heartbeat> heartbeat_;
  std::optional<tg_Fault> fault_;
  std::deque<tg_Log> logs_;
  std::chrono::steady_clock::time_point heard_;
};

}  // namespace tetragauge
