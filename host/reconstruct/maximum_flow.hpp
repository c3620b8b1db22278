// SPDX-License-Identifier: GPL-3.0-or-later
// Maximum flow between cells of four neighbours each, in place: no list of edges is built.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {

constexpr uint32_t kNoNode = UINT32_MAX;

struct FlowNode {
  Votes excess = 0;                 // positive: what the source can send in; negative: what the sink can take
  std::array<Votes, 4> capacity{};  // out of this node to neighbour i
  std::array<uint32_t, 4> neighbour;  // kNoNode: none
  std::array<uint8_t, 4> mirror;      // this node's place among the neighbours of neighbour i
};

// Per node 1: the source still reaches it when the flow is at its maximum. That is the smallest source side
// among all minimum cuts, whatever the flow. Capacities and excess become what is left of them. In
// parallel, beginning with blocks of `smallest_block` nodes: best when neighbours have near numbers.
std::vector<uint8_t> source_side(std::vector<FlowNode>& nodes, uint32_t smallest_block = 1 << 14);

}  // namespace tetragauge
