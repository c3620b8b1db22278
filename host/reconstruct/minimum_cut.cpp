// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/minimum_cut.hpp"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/property_map/property_map.hpp>

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

using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, uint32_t, uint32_t>;
using EdgeDescriptor = boost::graph_traits<Graph>::edge_descriptor;

struct Edge {
  uint32_t from, to;
  Votes capacity;
};

// What the source still reaches in the residual network: the smallest source side among all minimum cuts.
std::vector<uint8_t> reachable_from_source(uint32_t nodes, const std::vector<Edge>& edges, uint32_t source,
                                           uint32_t sink) {
  // `edges` holds pairs: edge 2k + 1 is the reverse of 2k. Compressed rows keep each node's edges together.
  std::vector<uint32_t> row(nodes + 1, 0);
  for (const Edge& e : edges) ++row[e.from + 1];
  for (uint32_t v = 0; v < nodes; ++v) row[v + 1] += row[v];
  std::vector<uint32_t> place(edges.size()), next = row;
  for (size_t e = 0; e < edges.size(); ++e) place[e] = next[edges[e].from]++;
  std::vector<std::pair<uint32_t, uint32_t>> ends(edges.size());
  std::vector<Votes> capacity(edges.size()), residual(edges.size());
  std::vector<EdgeDescriptor> reverse(edges.size()), predecessor(nodes);
  for (size_t e = 0; e < edges.size(); ++e) {
    ends[place[e]] = {edges[e].from, edges[e].to};
    capacity[place[e]] = edges[e].capacity;
    reverse[place[e]] = EdgeDescriptor(edges[e].to, place[e ^ 1]);
  }
  const Graph graph(boost::edges_are_sorted, ends.begin(), ends.end(), nodes);

  std::vector<boost::default_color_type> colour(nodes);
  std::vector<long> distance(nodes);
  const auto by_edge = boost::get(boost::edge_index, graph);
  const auto by_node = boost::get(boost::vertex_index, graph);
  boost::boykov_kolmogorov_max_flow(graph, boost::make_iterator_property_map(capacity.begin(), by_edge),
                                    boost::make_iterator_property_map(residual.begin(), by_edge),
                                    boost::make_iterator_property_map(reverse.begin(), by_edge),
                                    boost::make_iterator_property_map(predecessor.begin(), by_node),
                                    boost::make_iterator_property_map(colour.begin(), by_node),
                                    boost::make_iterator_property_map(distance.begin(), by_node), by_node,
                                    source, sink);
  std::vector<uint8_t> reached(nodes, 0);
  std::vector<uint32_t> queue{source};
  reached[source] = 1;
  for (size_t at = 0; at < queue.size(); ++at) {
    for (uint32_t e = row[queue[at]]; e < row[queue[at] + 1]; ++e) {
      if (residual[e] <= 0 || reached[ends[e].second]) continue;
      reached[ends[e].second] = 1;
      queue.push_back(ends[e].second);
    }
  }
  return reached;
}

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
  const auto source = static_cast<uint32_t>(open.size()), sink = source + 1;
  std::vector<Edge> edges;
  for (const uint32_t c : open) {
    const Votes push = problem.for_air[c];
    if (push > 0) {
      edges.push_back({source, node[c], push});
      edges.push_back({node[c], source, 0});
    } else if (push < 0) {
      edges.push_back({node[c], sink, -push});
      edges.push_back({sink, node[c], 0});
    }
    for (int i = 0; i < 4; ++i) {
      const auto k = static_cast<size_t>(i);
      const uint32_t n = tetrahedra.cells[c].neighbour[k];
      if (n < c || side[n] != Side::open) continue;  // each facet once
      const Votes into_n = problem.cost[n][static_cast<size_t>(tetrahedra.mirror_index(c, i))];
      const Votes into_c = problem.cost[c][k];
      if (into_n == 0 && into_c == 0) continue;
      edges.push_back({node[c], node[n], into_n});
      edges.push_back({node[n], node[c], into_c});
    }
  }
  const std::vector<uint8_t> reached = reachable_from_source(sink + 1, edges, source, sink);
  for (const uint32_t c : open) air[c] = reached[node[c]];
  return air;
}

}  // namespace tetragauge
