// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/faulty_wire.hpp"

#include <algorithm>

#include "sim/noise.hpp"

namespace tetragauge {
namespace {

enum Draw : uint64_t { kFlip, kDrop, kDuplicate, kDelay, kBit, kDraws };

}  // namespace

FaultyWire::FaultyWire(const sim::LineFaults& faults, const std::vector<sim::TimeSpan>& cuts, uint64_t key)
    : faults_(faults),
      cuts_(cuts),
      key_(key),
      perfect_(faults.flip == 0 && faults.drop == 0 && faults.duplicate == 0 && faults.delay == 0 &&
               cuts.empty()) {}

void FaultyWire::send(uint8_t byte, uint64_t now_ns) {
  Held held{{byte, byte == 0}, now_ns};
  if (perfect_) {
    on_its_way_.push_back(held);
    return;
  }
  const uint64_t number = count_++;
  const auto draw = [&](Draw what) { return sim::combine_key(key_, number * kDraws + what); };
  const auto hit = [&](Draw what, double share) {
    return share > 0 && static_cast<double>(draw(what) >> 11) * 0x1p-53 < share;
  };
  if (hit(kFlip, faults_.flip)) held.arrival.byte = static_cast<uint8_t>(byte ^ (1u << (draw(kBit) % 8)));
  if (hit(kDrop, faults_.drop) || sim::any_holds(cuts_, static_cast<int64_t>(now_ns)))
    held.arrival.byte.reset();
  if (hit(kDelay, faults_.delay)) held.due_ns += static_cast<uint64_t>(faults_.delay_ns);
  held.due_ns = last_due_ns_ = std::max(held.due_ns, last_due_ns_);
  if (hit(kDuplicate, faults_.duplicate)) on_its_way_.push_back({{held.arrival.byte, false}, held.due_ns});
  on_its_way_.push_back(held);
}

std::optional<FaultyWire::Arrival> FaultyWire::take(uint64_t now_ns) {
  if (on_its_way_.empty() || on_its_way_.front().due_ns > now_ns) return std::nullopt;
  const Arrival arrival = on_its_way_.front().arrival;
  on_its_way_.pop_front();
  return arrival;
}

uint64_t FaultyWire::next_due_ns() const {
  return on_its_way_.empty() ? std::numeric_limits<uint64_t>::max() : on_its_way_.front().due_ns;
}

}  // namespace tetragauge
