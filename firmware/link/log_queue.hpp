// SPDX-License-Identifier: Apache-2.0
// Log lines that wait for the host: a few, oldest first; those for which there is no room are counted.
#pragma once

#include <cstdint>

#include "protocol/machine.pb.h"

namespace tetragauge {

class LogQueue {
 public:
  static constexpr uint32_t kLines = 16;

  void add(tg_LogLevel level, uint64_t clock_us, const char* literal) {
    if (count_ == kLines) {
      ++dropped_;
      return;
    }
    lines_[(first_ + count_++) % kLines] = {level, clock_us, literal};
  }
  bool empty() const { return count_ == 0; }
  uint32_t dropped() const { return dropped_; }

  // The oldest one; the queue is not empty.
  void take(tg_Log* log) {
    const Line& line = lines_[first_];
    log->level = line.level;
    log->clock_us = line.clock_us;
    uint32_t i = 0;
    for (; i + 1 < sizeof log->text && line.literal[i] != '\0'; ++i) log->text[i] = line.literal[i];
    log->text[i] = '\0';
    first_ = (first_ + 1) % kLines;
    --count_;
  }

 private:
  struct Line {
    tg_LogLevel level = tg_LogLevel_LOG_INFO;
    uint64_t clock_us = 0;
    const char* literal = "";
  };
  Line lines_[kLines];
  uint32_t first_ = 0, count_ = 0, dropped_ = 0;
};

}  // namespace tetragauge
