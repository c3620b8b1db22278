// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/minimum_cut.hpp"

#include "host/reconstruct/maximum_flow.hpp"

namespace tetragauge {
namespace {

enum class Side : uint8_t { open, solid, air };

// Most cells need no maximum flow. A cell whose push towards air is more than everything that its open
// neighbours could lose by it is air in every minimum cut; one whose push towards solid is at least as much
// is solid in the one with the least air. Each decision goes to the neighbours as a push of their own, so it
// spreads like a wave from the sensors to the noise layer. The order of decisions does not matter.
class Settler {
 public:
  Settler(const Tetrahedra& tetrahedra, CutProblem& problem)
      : tetrahedra_(tetrahedra), problem_(problem), side_(tetrahedra.cells.size(), Side::open) {}

  std::vector<Side> run() {
    for (uint32_t c = 0; c < side_.size(); ++c) {
      if (side_[c] == Side::open && problem_.for_air[c] != 0) try_to_settle(c);
      spread();
    }
    for (uint32_t c = 0; c < side_.size(); ++c) {  // those without any push of their own
      if (side_[c] == Side::open) try_to_settle(c);
      spread();
    }
    return std::move(side_);
  }

 private:
  Votes cost_from_air(uint32_t c, int i) const {  // c air, neighbour i solid
    const uint32_t n = tetrahedra_.cells[c].neighbour[static_cast<size_t>(i)];
    return problem_.cost[n][static_cast<size_t>(tetrahedra_.mirror_index(c, i))];
  }

  void try_to_settle(uint32_t c) {
    const Votes push = problem_.for_air[c];
    Votes at_stake = 0;
    for (int i = 0; i < 4; ++i) {
      const auto k = static_cast<size_t>(i);
      if (side_[tetrahedra_.cells[c].neighbour[k]] != Side::open) continue;
      at_stake += push > 0 ? cost_from_air(c, i) : problem_.cost[c][k];
    }
    if (push > at_stake)
      settle(c, Side::air);
    else if (push <= 0 && -push >= at_stake)
      settle(c, Side::solid);
  }

  void settle(uint32_t c, Side side) {
    side_[c] = side;
    for (int i = 0; i < 4; ++i) {
      const auto k = static_cast<size_t>(i);
      const uint32_t n = tetrahedra_.cells[c].neighbour[k];
      if (side_[n] == Side::open)
        problem_.for_air[n] += side == Side::air ? cost_from_air(c, i) : -problem_.cost[c][k];
    }
    settled_.push_back(c);
  }

  void spread() {
    while (!settled_.empty()) {
      const uint32_t c = settled_.back();
      settled_.pop_back();
      for (const uint32_t n : tetrahedra_.cells[c].neighbour) {
        if (side_[n] == Side::open) try_to_settle(n);
      }
    }
  }

  const Tetrahedra& tetrahedra_;
  CutProblem& problem_;
  std::vector<Side> side_;
  std::vector<uint32_t> settled_;
};

}  // namespace

std::vector<uint8_t> minimum_cut(const Tetrahedra& tetrahedra, CutProblem problem) {
  const size_t cells = tetrahedra.cells.size();
  const std::vector<Side> side = Settler(tetrahedra, problem).run();
  std::vector<uint8_t> air(cells);
  std::vector<uint32_t> node(cells), open;
  for (uint32_t c = 0; c < cells; ++c) {
    air[c] = side[c] == Side::air;
    if (side[c] != Side::open) continue;
    node[c] = static_cast<uint32_t>(open.size());
    open.push_back(c);
  }
  std::vector<FlowNode> nodes(open.size());
  for (size_t v = 0; v < open.size(); ++v) {
    const uint32_t c = open[v];
    nodes[v].excess = problem.for_air[c];
    for (size_t i = 0; i < 4; ++i) {
      const uint32_t n = tetrahedra.cells[c].neighbour[i];
      const int mirror = tetrahedra.mirror_index(c, static_cast<int>(i));
      nodes[v].neighbour[i] = side[n] == Side::open ? node[n] : kNoNode;
      nodes[v].mirror[i] = static_cast<uint8_t>(mirror);
      nodes[v].capacity[i] = problem.cost[n][static_cast<size_t>(mirror)];
    }
  }
  const std::vector<uint8_t> reached = source_side(nodes);
  for (const uint32_t c : open) air[c] = reached[node[c]];
  return air;
}

}  // namespace tetragauge
