// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/label_cells.hpp"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/property_map/property_map.hpp>

namespace tetragauge {
namespace {

using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, uint32_t, uint32_t>;
using EdgeDescriptor = boost::graph_traits<Graph>::edge_descriptor;

struct Edge {
  uint32_t from, to;
  Votes capacity;
};

// Air is what the source still reaches in the residual network: the smallest air among all minimum cuts.
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

double facet_area(const Tetrahedra& tetrahedra, const Cell& cell, int i) {
  const auto& f = kFacet[static_cast<size_t>(i)];
  const Vec3& a = tetrahedra.vertices[cell.vertex[f[0]]];
  return 0.5 * (tetrahedra.vertices[cell.vertex[f[1]]] - a)
                   .cross(tetrahedra.vertices[cell.vertex[f[2]]] - a)
                   .norm();
}

std::vector<uint8_t> cut(const Tetrahedra& tetrahedra, const Visibility& visibility, double point_area_mm2) {
  const double cost_per_mm2 = 0.01 * static_cast<double>(kOneRay) / point_area_mm2;
  const auto cells = static_cast<uint32_t>(tetrahedra.cells.size());
  const uint32_t source = cells, sink = cells + 1;
  std::vector<Edge> edges;
  for (uint32_t c = 0; c < cells; ++c) {
    const Cell& cell = tetrahedra.cells[c];
    // One vote of a thousandth of a ray makes an infinite cell air by default.
    const Votes terminal =
        visibility.from_outside[c] + (cell.is_infinite() ? 1 : 0) - visibility.into_inside[c];
    if (terminal > 0) {
      edges.push_back({source, c, terminal});
      edges.push_back({c, source, 0});
    } else if (terminal < 0) {
      edges.push_back({c, sink, -terminal});
      edges.push_back({sink, c, 0});
    }
    for (int i = 0; i < 4; ++i) {
      const uint32_t n = cell.neighbour[static_cast<size_t>(i)];
      if (n < c) continue;  // each facet once
      const Votes into_n = visibility.entered_through[n][static_cast<size_t>(tetrahedra.mirror_index(c, i))];
      const Votes into_c = visibility.entered_through[c][static_cast<size_t>(i)];
      Votes area = 0;
      if (!cell.is_infinite())
        area = std::lround(std::min(1e6, cost_per_mm2 * facet_area(tetrahedra, cell, i)));
      else if (cell.vertex[static_cast<size_t>(i)] == kInfiniteVertex)
        area = std::lround(std::min(
            1e6, cost_per_mm2 * facet_area(tetrahedra, tetrahedra.cells[n], tetrahedra.mirror_index(c, i))));
      if (into_n + area == 0 && into_c + area == 0) continue;
      edges.push_back({c, n, into_n + area});
      edges.push_back({n, c, into_c + area});
    }
  }
  std::vector<uint8_t> air = reachable_from_source(cells + 2, edges, source, sink);
  air.resize(cells);
  return air;
}

}  // namespace

std::vector<uint8_t> label_cells(const Tetrahedra& tetrahedra, const Visibility& visibility,
                                 ReconstructMethod method, double point_area_mm2) {
  if (method == ReconstructMethod::cut) return cut(tetrahedra, visibility, point_area_mm2);
  std::vector<uint8_t> air = visibility.crossed;
  for (size_t c = 0; c < air.size(); ++c) {
    if (tetrahedra.cells[c].is_infinite() && visibility.into_inside[c] == 0) air[c] = 1;
  }
  return air;
}

}  // namespace tetragauge
