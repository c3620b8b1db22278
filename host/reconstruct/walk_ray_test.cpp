// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/walk_ray.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace tetragauge {
namespace {

using Integers = std::array<int64_t, 3>;

int64_t determinant(const Integers& a, const Integers& b, const Integers& c, const Integers& d) {
  const auto minus = [](const Integers& p, const Integers& q) {
    return Integers{p[0] - q[0], p[1] - q[1], p[2] - q[2]};
  };
  const Integers u = minus(b, a), v = minus(c, a), w = minus(d, a);
  return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
         u[2] * (v[0] * w[1] - v[1] * w[0]);
}

Integers integers(const Vec3& p) {
  return {std::llround(p.x()), std::llround(p.y()), std::llround(p.z())};
}

// Exact in integers, by clipping the segment to the cell: whether s t crosses the cell's interior.
bool crosses_interior(const Tetrahedra& tetrahedra, const Cell& cell, const Vec3& s, const Vec3& t) {
  // The parameter of the segment lies in (low_n / low_d, high_n / high_d), denominators positive.
  int64_t low_n = 0, low_d = 1, high_n = 1, high_d = 1;
  for (size_t i = 0; i < 4; ++i) {
    const Integers a = integers(tetrahedra.vertices[cell.vertex[kFacet[i][0]]]),
                   b = integers(tetrahedra.vertices[cell.vertex[kFacet[i][1]]]),
                   c = integers(tetrahedra.vertices[cell.vertex[kFacet[i][2]]]);
    const int64_t at_s = determinant(a, b, c, integers(s)), at_t = determinant(a, b, c, integers(t));
    if (at_s <= 0 && at_t <= 0) return false;
    if (at_s > 0 && at_t > 0) continue;
    const int64_t n = std::abs(at_s), d = std::abs(at_s) + std::abs(at_t);
    if (at_s <= 0 && n * low_d > low_n * d) low_n = n, low_d = d;
    if (at_t <= 0 && n * high_d < high_n * d) high_n = n, high_d = d;
  }
  return low_n * high_d < high_n * low_d;
}

struct PointSet {
  const char* name;
  std::vector<Vec3> points;
};

std::vector<PointSet> adversarial_sets() {
  std::vector<PointSet> sets;
  PointSet grid{"grid", {}}, two_planes{"two planes", {}}, lines{"two skew lines", {}}, random{"random", {}},
      octahedron{"cospherical", {}}, fan{"fan", {}};
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) {
      for (int z = 0; z < 4; ++z) grid.points.emplace_back(x, y, z);
      two_planes.points.emplace_back(x, y, 0);
      two_planes.points.emplace_back(x, y, 3);
    }
  }
  for (int i = 0; i < 12; ++i) {
    lines.points.emplace_back(i, 0, 0);
    lines.points.emplace_back(0, i, 5);
  }
  std::mt19937 generator(7);
  for (int i = 0; i < 60; ++i)
    random.points.emplace_back(static_cast<double>(generator() % 17), static_cast<double>(generator() % 17),
                               static_cast<double>(generator() % 17));
  // All integer points at distance 3 from (0, 0, 0), and the centre.
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) {
      for (int z = -3; z <= 3; ++z) {
        if (x * x + y * y + z * z == 9) octahedron.points.emplace_back(x, y, z);
      }
    }
  }
  octahedron.points.emplace_back(0, 0, 0);
  for (int i = -6; i <= 6; ++i) fan.points.emplace_back(i, i * i, 0);
  fan.points.emplace_back(0, 18, 9);
  fan.points.emplace_back(0, 18, -9);
  for (PointSet* set : {&grid, &two_planes, &lines, &random, &octahedron, &fan}) {
    std::sort(set->points.begin(), set->points.end(), [](const Vec3& a, const Vec3& b) {
      return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
    });
    set->points.erase(std::unique(set->points.begin(), set->points.end()), set->points.end());
    sets.push_back(*set);
  }
  return sets;
}

TEST(WalkRay, CrossesExactlyTheCellsThatClippingFinds) {
  Walk walk;
  size_t through_edges = 0;
  for (const PointSet& set : adversarial_sets()) {
    const auto tetrahedra = delaunay(set.points);
    ASSERT_TRUE(tetrahedra.ok()) << set.name;
    RayWalker walker(*tetrahedra);
    std::mt19937 generator(11);
    for (uint32_t v = 0; v < tetrahedra->vertices.size(); ++v) {
      for (int k = 0; k < 40; ++k) {
        // Targets inside and outside the hull, many of them in line with vertices, edges and facets.
        const auto coordinate = [&] { return static_cast<double>(static_cast<int>(generator() % 31) - 10); };
        const Vec3 target(coordinate(), coordinate(), coordinate());
        const Vec3 start = tetrahedra->vertices[v];
        if (target == start) continue;
        walker.walk(v, target, walk);
        ASSERT_NE(walk.end, Walk::End::lost) << set.name;
        std::set<uint32_t> walked, expected;
        uint32_t last_finite = kNoCell;
        for (const WalkStep& step : walk.steps) {
          if (tetrahedra->cells[step.cell].is_infinite()) continue;
          EXPECT_TRUE(walked.insert(step.cell).second) << set.name << ": a cell twice";
          if (step.facet_of_previous >= 0) {
            ASSERT_NE(last_finite, kNoCell);
            EXPECT_EQ(tetrahedra->cells[last_finite].neighbour[static_cast<size_t>(step.facet_of_previous)],
                      step.cell);
          } else {
            through_edges += last_finite != kNoCell ? 1 : 0;
          }
          last_finite = step.cell;
        }
        for (uint32_t c = 0; c < tetrahedra->cells.size(); ++c) {
          if (!tetrahedra->cells[c].is_infinite() &&
              crosses_interior(*tetrahedra, tetrahedra->cells[c], start, target))
            expected.insert(c);
        }
        ASSERT_EQ(walked, expected) << set.name << " from " << start.transpose() << " to "
                                    << target.transpose();
        bool inside = false;
        for (const Cell& cell : tetrahedra->cells) {
          if (cell.is_infinite()) continue;
          bool in = true;
          for (size_t i = 0; i < 4; ++i)
            in = in && determinant(integers(tetrahedra->vertices[cell.vertex[kFacet[i][0]]]),
                                   integers(tetrahedra->vertices[cell.vertex[kFacet[i][1]]]),
                                   integers(tetrahedra->vertices[cell.vertex[kFacet[i][2]]]),
                                   integers(target)) >= 0;
          inside = inside || in;
        }
        EXPECT_EQ(walk.end == Walk::End::reached_target, inside) << set.name;
      }
    }
  }
  EXPECT_GT(through_edges, 100u);  // the sets are as degenerate as they are meant to be
}

TEST(WalkRay, LosesNoneOfManyRaysThroughDegenerateSets) {
  Walk walk;
  size_t walked = 0, lost = 0;
  for (const PointSet& set : adversarial_sets()) {
    // Shrunk by a third: coordinates are no longer exact, so that degeneracies are near misses too.
    std::vector<Vec3> points = set.points;
    for (Vec3& p : points) p /= 3;
    const auto tetrahedra = delaunay(points);
    ASSERT_TRUE(tetrahedra.ok());
    RayWalker walker(*tetrahedra);
    std::mt19937 generator(5);
    for (int k = 0; k < 170000; ++k) {
      const auto coordinate = [&] {
        return static_cast<double>(static_cast<int>(generator() % 61) - 30) / 3;
      };
      const auto v = static_cast<uint32_t>(generator() % points.size());
      walker.walk(v, Vec3(coordinate(), coordinate(), coordinate()), walk);
      ++walked;
      if (walk.end == Walk::End::lost) ++lost;
    }
  }
  EXPECT_GT(walked, 1000000u);
  EXPECT_EQ(lost, 0u) << "of " << walked;
}

}  // namespace
}  // namespace tetragauge
