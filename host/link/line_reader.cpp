// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/link/line_reader.hpp"

#include <array>
#include <utility>

namespace tetragauge {
namespace {

// How long the destructor may have to wait.
constexpr std::chrono::milliseconds kSlice{50};

}  // namespace

LineReader::LineReader(Transport& transport)
    : transport_(transport), thread_([this] { read_until_stopped(); }) {}

LineReader::~LineReader() {
  stop_ = true;
  thread_.join();
}

void LineReader::read_until_stopped() {
  FrameReader frames;
  std::array<uint8_t, 4096> buffer;
  ReceivedMessage received;
  while (!stop_) {
    const auto count = transport_.read_some(buffer, kSlice);
    if (!count) {
      const std::lock_guard lock(mutex_);
      gone_ = count.error();
      came_.notify_one();
      return;
    }
    for (size_t i = 0; i < *count; ++i) {
      const bool good = frames.push(buffer[i]);
      if (good) {
        received.header = frames.frame().header;
        // A good frame that does not decode is of another version, which Hello has to say.
        if (!decode_message(frames.frame(), &received.message)) continue;
      } else if (frames.bad_frames() == bad_frames_) {
        continue;
      }
      const std::lock_guard lock(mutex_);
      bad_frames_ = frames.bad_frames();
      if (good) messages_.push_back(received);
      came_.notify_one();
    }
  }
}

Result<std::optional<ReceivedMessage>> LineReader::next(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  came_.wait_for(lock, timeout,
                 [this] { return !messages_.empty() || gone_ || bad_frames_ != bad_frames_said_; });
  std::optional<ReceivedMessage> message;
  if (!messages_.empty()) {
    message = messages_.front();
    messages_.pop_front();
  } else if (bad_frames_ != bad_frames_said_) {
    bad_frames_said_ = bad_frames_;
  } else if (gone_) {
    return *gone_;
  }
  return message;
}

}  // namespace tetragauge
