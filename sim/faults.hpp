// SPDX-License-Identifier: GPL-3.0-or-later
// What goes wrong, and when: `--faults SPEC` of the emulator. The words of a SPEC are in sim/README.md.
//
//   auto faults = parse_faults("link_flip=1e-4,interlock@2.5s,flash@3s+0.2s:5uA");
//
// Times are virtual, from power-on. What the line to the host does to a byte is a pure function of (seed,
// direction, number of the byte), so the same traffic suffers the same faults.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host/base/result.hpp"

namespace tetragauge::sim {

struct TimeSpan {
  int64_t from_ns = 0;
  int64_t until_ns = std::numeric_limits<int64_t>::max();  // not included; by default for good

  bool holds(int64_t now_ns) const { return from_ns <= now_ns && now_ns < until_ns; }
};

inline bool any_holds(const std::vector<TimeSpan>& spans, int64_t now_ns) {
  for (const TimeSpan& span : spans) {
    if (span.holds(now_ns)) return true;
  }
  return false;
}

struct Flash {
  TimeSpan when;
  double current_A = 0;  // of each detector, spread over it
};

struct RailedChannel {
  TimeSpan when;
  size_t camera = 0, channel = 0;  // 0 or 1; 0 .. 3: x1 x2 y1 y2
};

// Of the machine itself.
struct MachineFaults {
  std::vector<TimeSpan> interlock_open;
  std::vector<TimeSpan> limit_low, limit_high;  // the slide's end switches
  std::vector<TimeSpan> laser_failing;          // dark, and its driver says so
  std::vector<TimeSpan> laser_dark;             // dark, and nobody says so
  std::array<std::vector<TimeSpan>, 2> mirror_stuck;
  std::vector<Flash> flashes;
  std::vector<RailedChannel> railed;
};

// Of the line, in one direction. Shares of the bytes.
struct LineFaults {
  double flip = 0;  // one bit of the byte
  double drop = 0;
  double duplicate = 0;
  double delay = 0;  // held back with all that come after it
  int64_t delay_ns = 20'000'000;
};

struct Faults {
  MachineFaults machine;
  LineFaults to_host, to_machine;
  std::vector<TimeSpan> line_cut;  // both directions
  uint64_t seed = 1;               // of the line's faults; the world has its own
};

// Error (usage): names the word that is wrong and what it should be.
Result<Faults> parse_faults(const std::string& spec);

}  // namespace tetragauge::sim
