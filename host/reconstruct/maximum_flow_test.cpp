// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/maximum_flow.hpp"

#include <gtest/gtest.h>

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/edmonds_karp_max_flow.hpp>
#include <random>

namespace tetragauge {
namespace {

// A torus of columns x rows nodes, each with its four neighbours.
std::vector<FlowNode> random_torus(uint32_t columns, uint32_t rows, uint32_t seed, uint32_t silent_percent) {
  std::mt19937 generator(seed);
  const auto votes = [&](uint32_t most) {
    return generator() % 100 < silent_percent ? 0 : static_cast<Votes>(generator() % most);
  };
  std::vector<FlowNode> nodes(columns * rows);
  for (uint32_t y = 0; y < rows; ++y) {
    for (uint32_t x = 0; x < columns; ++x) {
      FlowNode& node = nodes[y * columns + x];
      // Far more at single nodes than its neighbours can carry off, so that flow has far to go.
      node.excess = generator() % 8 == 0 ? votes(200) - votes(200) : 0;
      node.neighbour = {y * columns + (x + 1) % columns, (y + 1) % rows * columns + x,
                        y * columns + (x + columns - 1) % columns, (y + rows - 1) % rows * columns + x};
      node.mirror = {2, 3, 0, 1};
      for (Votes& capacity : node.capacity) capacity = votes(30);
    }
  }
  return nodes;
}

// By another algorithm and another library: what the source reaches in the residual network.
std::vector<uint8_t> reached_by_edmonds_karp(const std::vector<FlowNode>& nodes) {
  using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
  using Graph = boost::adjacency_list<
      boost::vecS, boost::vecS, boost::directedS, boost::no_property,
      boost::property<boost::edge_capacity_t, Votes,
                      boost::property<boost::edge_residual_capacity_t, Votes,
                                      boost::property<boost::edge_reverse_t, Traits::edge_descriptor>>>>;
  const size_t source = nodes.size(), sink = source + 1;
  Graph graph(nodes.size() + 2);
  const auto capacity = boost::get(boost::edge_capacity, graph);
  const auto residual = boost::get(boost::edge_residual_capacity, graph);
  const auto reverse = boost::get(boost::edge_reverse, graph);
  const auto add = [&](size_t from, size_t to, Votes there, Votes back) {
    const auto forth = boost::add_edge(from, to, graph).first, other = boost::add_edge(to, from, graph).first;
    capacity[forth] = there;
    capacity[other] = back;
    reverse[forth] = other;
    reverse[other] = forth;
  };
  for (size_t v = 0; v < nodes.size(); ++v) {
    if (nodes[v].excess > 0) add(source, v, nodes[v].excess, 0);
    if (nodes[v].excess < 0) add(v, sink, -nodes[v].excess, 0);
    for (size_t i = 0; i < 2; ++i)
      add(v, nodes[v].neighbour[i], nodes[v].capacity[i], nodes[nodes[v].neighbour[i]].capacity[i + 2]);
  }
  boost::edmonds_karp_max_flow(graph, source, sink);
  std::vector<uint8_t> reached(nodes.size() + 2, 0);
  std::vector<size_t> queue{source};
  reached[source] = 1;
  for (size_t at = 0; at < queue.size(); ++at) {
    for (const auto& edge : boost::make_iterator_range(boost::out_edges(queue[at], graph))) {
      const size_t to = boost::target(edge, graph);
      if (residual[edge] <= 0 || reached[to]) continue;
      reached[to] = 1;
      queue.push_back(to);
    }
  }
  reached.resize(nodes.size());
  return reached;
}

TEST(MaximumFlow, ReachesWhatEdmondsKarpReachesWhateverTheBlocks) {
  for (uint32_t seed = 0; seed < 24; ++seed) {
    const std::vector<FlowNode> nodes = random_torus(5 + seed, 17 + seed % 7, seed, 10 * (seed % 6));
    const std::vector<uint8_t> wanted = reached_by_edmonds_karp(nodes);
    for (const uint32_t block : {1u, 7u, 64u, 1u << 14}) {
      std::vector<FlowNode> work = nodes;
      ASSERT_EQ(source_side(work, block), wanted) << "seed " << seed << ", blocks of " << block;
    }
  }
}

TEST(MaximumFlow, NoNodesAreNoProblem) {
  std::vector<FlowNode> none;
  EXPECT_TRUE(source_side(none).empty());
}

}  // namespace
}  // namespace tetragauge
