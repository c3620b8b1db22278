// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/maximum_flow.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace tetragauge {
namespace {

enum class Side : uint8_t { free, source, sink };
constexpr uint8_t kRoot = 4, kOrphan = 5;  // in place of the parent's number among the neighbours

struct FlowTree {
  uint32_t date = 0;      // when the distance was last known to be true
  uint32_t distance = 0;  // to the root
  uint8_t parent = kOrphan;
  Side side = Side::free;
  bool is_active = false;
};

// Two trees, from the source's nodes and from the sink's, grow until they touch; the path is filled, and what
// was cut off by that looks for a new parent. Boykov, Kolmogorov, PAMI 26 (2004) 1124, section 3; distances
// to the root and their dates as in Kolmogorov's thesis (2004), section 3.2.3.
class TreePairFlow {
 public:
  // Works on the nodes from `begin` to `end`, as if there were no others.
  TreePairFlow(std::vector<FlowNode>& nodes, std::vector<FlowTree>& trees, uint32_t begin, uint32_t end,
               uint32_t date)
      : nodes_(nodes), trees_(trees), begin_(begin), size_(end - begin), date_(date) {}

  void plant_roots() {
    for (uint32_t v = begin_; v < begin_ + size_; ++v) {
      if (nodes_[v].excess == 0) continue;
      trees_[v].parent = kRoot;
      trees_[v].distance = 1;
      trees_[v].side = nodes_[v].excess > 0 ? Side::source : Side::sink;
      activate(v);
    }
  }

  // Of the parts it was in until now, `part` nodes long.
  void activate_borders(uint32_t part) {
    for (uint32_t v = begin_; v < begin_ + size_; ++v) {
      if (trees_[v].side == Side::free) continue;
      for (const uint32_t n : nodes_[v].neighbour) {
        if (is_here(n) && n / part != v / part) activate(v);
      }
    }
  }

  void activate(uint32_t v) {
    if (trees_[v].is_active) return;
    trees_[v].is_active = true;
    active_.push_back(v);
  }

  // Until nothing can grow any more: the flow is at its maximum.
  void run() {
    while (!active_.empty()) {
      // First come, first served: what becomes active meanwhile waits for the next turn.
      now_.clear();
      now_.swap(active_);
      for (const uint32_t v : now_) {
        trees_[v].is_active = false;
        if (trees_[v].side != Side::free) grow(v);
      }
    }
  }

  uint32_t date() const { return date_; }

 private:
  bool is_here(uint32_t v) const { return v - begin_ < size_; }  // kNoNode is not

  // What can still flow from v to its neighbour i, or (from the sink's side) from there to v.
  Votes outward(uint32_t v, size_t i, Side side) const {
    const FlowNode& node = nodes_[v];
    return side == Side::source ? node.capacity[i] : nodes_[node.neighbour[i]].capacity[node.mirror[i]];
  }
  Votes inward(uint32_t v, size_t i, Side side) const {
    return outward(v, i, side == Side::source ? Side::sink : Side::source);
  }

  void grow(uint32_t v) {
    const Side side = trees_[v].side;
    for (size_t i = 0; i < 4; ++i) {
      const uint32_t n = nodes_[v].neighbour[i];
      if (!is_here(n)) continue;
      // The same two nodes may have room for more than one path.
      while (trees_[v].side == side && trees_[n].side != Side::free && trees_[n].side != side &&
             outward(v, i, side) > 0) {
        if (side == Side::source)
          augment(v, i);
        else
          augment(n, nodes_[v].mirror[i]);
      }
      if (trees_[v].side != side) return;
      if (trees_[n].side == Side::free && outward(v, i, side) > 0) {
        trees_[n].date = trees_[v].date;
        trees_[n].distance = trees_[v].distance + 1;
        trees_[n].parent = nodes_[v].mirror[i];
        trees_[n].side = side;
        activate(n);
      } else if (trees_[n].side == side && trees_[n].parent < kRoot && trees_[n].date <= trees_[v].date &&
                 trees_[n].distance > trees_[v].distance + 1 && outward(v, i, side) > 0) {
        trees_[n].parent = nodes_[v].mirror[i];  // a shorter way to the root
        trees_[n].date = trees_[v].date;
        trees_[n].distance = trees_[v].distance + 1;
      }
    }
  }

  uint32_t parent(uint32_t v) const { return nodes_[v].neighbour[trees_[v].parent]; }

  // Fills the path from the source's root over v, its neighbour i in the sink's tree and on to that root.
  void augment(uint32_t v, size_t i) {
    const uint32_t n = nodes_[v].neighbour[i];
    Votes flow = nodes_[v].capacity[i];
    uint32_t at = v;
    for (; trees_[at].parent != kRoot; at = parent(at))
      flow = std::min(flow, inward(at, trees_[at].parent, Side::source));
    flow = std::min(flow, nodes_[at].excess);
    for (at = n; trees_[at].parent != kRoot; at = parent(at))
      flow = std::min(flow, inward(at, trees_[at].parent, Side::sink));
    flow = std::min(flow, -nodes_[at].excess);

    push(v, i, flow);
    for (at = v; trees_[at].parent != kRoot;) {
      const uint32_t up = parent(at);
      push(up, nodes_[at].mirror[trees_[at].parent], flow);
      if (inward(at, trees_[at].parent, Side::source) == 0) orphan(at);
      at = up;
    }
    nodes_[at].excess -= flow;
    if (nodes_[at].excess == 0) orphan(at);
    for (at = n; trees_[at].parent != kRoot;) {
      const uint32_t up = parent(at);
      push(at, trees_[at].parent, flow);
      if (inward(at, trees_[at].parent, Side::sink) == 0) orphan(at);
      at = up;
    }
    nodes_[at].excess += flow;
    if (nodes_[at].excess == 0) orphan(at);

    ++date_;
    for (size_t next = 0; next < orphans_.size(); ++next) adopt(orphans_[next]);
    orphans_.clear();
  }

  void push(uint32_t v, size_t i, Votes flow) {
    nodes_[v].capacity[i] -= flow;
    nodes_[nodes_[v].neighbour[i]].capacity[nodes_[v].mirror[i]] += flow;
  }

  void orphan(uint32_t v) {
    trees_[v].parent = kOrphan;
    orphans_.push_back(v);
  }

  // Distance of v from its root, 0 if it hangs from an orphan; leaves today's date along the way.
  uint32_t distance_to_root(uint32_t v) {
    uint32_t steps = 1, at = v;
    for (;; ++steps, at = parent(at)) {
      if (trees_[at].parent == kOrphan) return 0;
      if (trees_[at].date == date_) {
        steps += trees_[at].distance - 1;
        break;
      }
      if (trees_[at].parent == kRoot) {
        trees_[at].date = date_;
        trees_[at].distance = 1;
        break;
      }
    }
    uint32_t distance = steps;
    for (at = v; trees_[at].date != date_; at = parent(at)) {
      trees_[at].date = date_;
      trees_[at].distance = distance--;
    }
    return steps;
  }

  void adopt(uint32_t v) {
    const Side side = trees_[v].side;
    uint32_t nearest = UINT32_MAX;
    uint8_t parent = kOrphan;
    for (uint8_t i = 0; i < 4; ++i) {
      const uint32_t n = nodes_[v].neighbour[i];
      if (!is_here(n) || trees_[n].side != side || inward(v, i, side) <= 0) continue;
      const uint32_t distance = distance_to_root(n);
      if (distance == 0 || distance >= nearest) continue;
      nearest = distance;
      parent = i;
    }
    if (parent != kOrphan) {
      trees_[v].date = date_;
      trees_[v].distance = nearest + 1;
      trees_[v].parent = parent;
      return;
    }
    for (size_t i = 0; i < 4; ++i) {
      const uint32_t n = nodes_[v].neighbour[i];
      if (!is_here(n) || trees_[n].side != side) continue;
      if (inward(v, i, side) > 0) activate(n);
      if (trees_[n].parent == nodes_[v].mirror[i]) orphan(n);
    }
    trees_[v].side = Side::free;
  }

  std::vector<FlowNode>& nodes_;
  std::vector<FlowTree>& trees_;
  const uint32_t begin_, size_;
  uint32_t date_;
  std::vector<uint32_t> active_, now_, orphans_;
};

}  // namespace

std::vector<uint8_t> source_side(std::vector<FlowNode>& nodes, uint32_t smallest_block) {
  // First small blocks, each for itself, in parallel and within the processor's cache; then four neighbouring
  // blocks together, from what they have left, and so on to the whole: only trees that touch across a border
  // still grow (after Liu, Sun, CVPR 2010).
  constexpr uint32_t kTogether = 4;
  const auto count = static_cast<uint32_t>(nodes.size());
  std::vector<FlowTree> trees(nodes.size());
  std::vector<uint32_t> dates;  // of the blocks, as far as they have come
  for (uint64_t block = smallest_block, part = 0;; part = block, block *= kTogether) {
    const auto blocks = static_cast<uint32_t>((count + block - 1) / block);
    std::vector<uint32_t> dates_now(blocks);
    tbb::parallel_for(uint32_t{0}, blocks, [&](uint32_t b) {
      const auto begin = static_cast<uint32_t>(b * block);
      const auto end = static_cast<uint32_t>(std::min<uint64_t>(count, begin + block));
      uint32_t date = 0;
      for (size_t k = kTogether * b; k < std::min<size_t>(dates.size(), kTogether * (b + 1)); ++k)
        date = std::max(date, dates[k] + 1);
      TreePairFlow flow(nodes, trees, begin, end, date);
      if (part == 0)
        flow.plant_roots();
      else
        flow.activate_borders(static_cast<uint32_t>(part));
      flow.run();
      dates_now[b] = flow.date();
    });
    dates = std::move(dates_now);
    if (blocks <= 1) break;
  }
  std::vector<uint8_t> result(nodes.size());
  for (uint32_t v = 0; v < count; ++v) result[v] = trees[v].side == Side::source;
  return result;
}

}  // namespace tetragauge
