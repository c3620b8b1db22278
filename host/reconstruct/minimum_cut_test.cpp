// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/minimum_cut.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace tetragauge {
namespace {

Votes cost_of(const Tetrahedra& tetrahedra, const CutProblem& problem, const std::vector<uint8_t>& air) {
  Votes total = 0;
  for (uint32_t c = 0; c < air.size(); ++c) {
    if (!air[c] && problem.for_air[c] > 0) total += problem.for_air[c];
    if (air[c] && problem.for_air[c] < 0) total -= problem.for_air[c];
    for (size_t i = 0; i < 4; ++i) {
      if (!air[c] && air[tetrahedra.cells[c].neighbour[i]]) total += problem.cost[c][i];
    }
  }
  return total;
}

CutProblem random_problem(const Tetrahedra& tetrahedra, uint32_t seed, uint32_t silent_percent) {
  std::mt19937 generator(seed);
  CutProblem problem;
  problem.for_air.resize(tetrahedra.cells.size());
  problem.cost.resize(tetrahedra.cells.size());
  const auto votes = [&](uint32_t most) {
    return generator() % 100 < silent_percent ? 0 : static_cast<Votes>(generator() % most);
  };
  for (size_t c = 0; c < problem.cost.size(); ++c) {
    problem.for_air[c] = votes(9) - votes(9);
    for (Votes& cost : problem.cost[c]) cost = votes(5);
  }
  return problem;
}

// All divisions tried in turn: the cheapest, and the fewest cells of air at that price.
TEST(MinimumCut, IsTheCheapestDivisionWithTheLeastAir) {
  const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 6), Vec3(4, 5, 7)};
  const auto tetrahedra = delaunay(points);
  ASSERT_TRUE(tetrahedra.ok());
  const size_t cells = tetrahedra->cells.size();
  ASSERT_LE(cells, 12u);
  for (uint32_t seed = 0; seed < 400; ++seed) {
    const CutProblem problem = random_problem(*tetrahedra, seed, 20 * (seed % 5));
    Votes least = std::numeric_limits<Votes>::max();
    std::vector<uint8_t> best;
    long best_air = 0;
    for (uint32_t mask = 0; mask < 1u << cells; ++mask) {
      std::vector<uint8_t> air(cells);
      for (size_t c = 0; c < cells; ++c) air[c] = mask >> c & 1;
      const Votes cost = cost_of(*tetrahedra, problem, air);
      const long count = std::count(air.begin(), air.end(), 1);
      if (cost < least || (cost == least && count < best_air)) least = cost, best = air, best_air = count;
    }
    ASSERT_EQ(minimum_cut(*tetrahedra, problem), best) << "seed " << seed;
  }
}

// The weight of a maximum flow, by shortest augmenting paths on a plain matrix, is that of the minimum cut.
Votes maximum_flow(const Tetrahedra& tetrahedra, const CutProblem& problem) {
  const size_t n = tetrahedra.cells.size(), source = n, sink = n + 1;
  std::vector<std::vector<Votes>> residual(n + 2, std::vector<Votes>(n + 2, 0));
  for (size_t c = 0; c < n; ++c) {
    residual[source][c] = std::max<Votes>(0, problem.for_air[c]);
    residual[c][sink] = std::max<Votes>(0, -problem.for_air[c]);
    for (size_t i = 0; i < 4; ++i) residual[tetrahedra.cells[c].neighbour[i]][c] += problem.cost[c][i];
  }
  for (Votes flow = 0;;) {
    std::vector<size_t> from(n + 2, SIZE_MAX), queue{source};
    from[source] = source;
    for (size_t at = 0; at < queue.size() && from[sink] == SIZE_MAX; ++at) {
      for (size_t v = 0; v < n + 2; ++v) {
        if (from[v] == SIZE_MAX && residual[queue[at]][v] > 0) from[v] = queue[at], queue.push_back(v);
      }
    }
    if (from[sink] == SIZE_MAX) return flow;
    Votes step = std::numeric_limits<Votes>::max();
    for (size_t v = sink; v != source; v = from[v]) step = std::min(step, residual[from[v]][v]);
    for (size_t v = sink; v != source; v = from[v])
      residual[from[v]][v] -= step, residual[v][from[v]] += step;
    flow += step;
  }
}

TEST(MinimumCut, CostsAsMuchAsTheMaximumFlow) {
  std::mt19937 generator(3);
  for (uint32_t seed = 0; seed < 30; ++seed) {
    std::vector<Vec3> points;
    for (int i = 0; i < 25; ++i)
      points.emplace_back(static_cast<double>(generator() % 1000), static_cast<double>(generator() % 1000),
                          static_cast<double>(generator() % 1000));
    const auto tetrahedra = delaunay(points);
    ASSERT_TRUE(tetrahedra.ok());
    const CutProblem problem = random_problem(*tetrahedra, seed, 15 * (seed % 6));
    EXPECT_EQ(cost_of(*tetrahedra, problem, minimum_cut(*tetrahedra, problem)),
              maximum_flow(*tetrahedra, problem))
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace tetragauge
