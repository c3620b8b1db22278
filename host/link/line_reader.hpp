// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the line in a thread of its own, so that the port's small buffer never overflows while the session
// writes to a slow disk, and hands over whole messages:
//
//   LineReader reader(transport);
//   auto message = reader.next(milliseconds(300));
//
// It answers nothing by itself: a session that hangs must look silent to the machine, which then pauses with
// the laser off.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "host/link/transport.hpp"
#include "protocol/message.hpp"

namespace tetragauge {

struct ReceivedMessage {
  FrameHeader header;
  tg_MachineMessage message = tg_MachineMessage_init_zero;
};

class LineReader {
 public:
  explicit LineReader(Transport& transport);  // which must outlive it
  ~LineReader();                              // within some 50 ms
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  // The next message in the order they came. nullopt: none came in time, or a broken frame was dropped
  // meanwhile, after which whoever waits for something may ask for it again. Error: the line is gone, and all
  // that came before has been taken.
  Result<std::optional<ReceivedMessage>> next(std::chrono::milliseconds timeout);

  // Broken ones since the start.
  uint32_t bad_frames() const { return bad_frames_; }

 private:
  void read_until_stopped();

  Transport& transport_;
  std::atomic<bool> stop_{false};
  std::atomic<uint32_t> bad_frames_{0};
  std::mutex mutex_;  // of the members below
  std::condition_variable came_;
  std::deque<ReceivedMessage> messages_;
  std::optional<Error> gone_;
  uint32_t bad_frames_said_ = 0;
  std::thread thread_;  // the last member: it uses the others
};

}  // namespace tetragauge
