// SPDX-License-Identifier: Apache-2.0
// One direction of the line between board and host, with whatever goes wrong on it (sim/faults.hpp). Bytes
// keep their order: one that is held back holds back all behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <vector>

#include "sim/faults.hpp"

namespace tetragauge {

class FaultyWire {
 public:
  // `key` makes the two directions differ.
  FaultyWire(const sim::LineFaults& faults, const std::vector<sim::TimeSpan>& cuts, uint64_t key);

  void send(uint8_t byte, uint64_t now_ns);

  // What comes out at the other end by `now_ns`, one after the other.
  struct Arrival {
    std::optional<uint8_t> byte;  // nothing: it was lost
    bool frame_end = false;       // the sender's frame ended with it, however it arrived
  };
  std::optional<Arrival> take(uint64_t now_ns);
  // When something comes out; uint64_t's largest value when nothing is on its way.
  uint64_t next_due_ns() const;
  void clear() { on_its_way_.clear(); }

 private:
  struct Held {
    Arrival arrival;
    uint64_t due_ns = 0;
  };

  sim::LineFaults faults_;
  std::vector<sim::TimeSpan> cuts_;
  uint64_t key_;
  bool perfect_;
  uint64_t count_ = 0;  // bytes sent so far
  uint64_t last_due_ns_ = 0;
  std::deque<Held> on_its_way_;
};

}  // namespace tetragauge
