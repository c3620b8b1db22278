// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/compare_cells.hpp"

#include <gtest/gtest.h>

#include <random>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/synthetic_scan.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {
namespace {

// All rays walked anew through the new triangulation give the same votes, cell by cell.
void expect_same_votes(size_t more, double reach_mm) {
  synthetic::ScanPlan plan;
  plan.centre = Vec3(40, 30, 30);
  plan.half_width_mm = 62;
  plan.pitch_mm = 4;
  plan.sigma_mm = 0.05;
  const Scan scan = synthetic::scan_part(synthetic::staircase(), plan);
  AveragedPoints averaged = average_points(scan);
  DelaunayTriangulation triangulation;
  triangulation.add(averaged.vertices);
  const auto before = triangulation.tetrahedra();
  ASSERT_TRUE(before.ok());
  const Visibility votes_before = vote_visibility(*before, scan, averaged);

  std::mt19937 generator(4);
  std::uniform_real_distribution<double> coordinate(-reach_mm, reach_mm);
  for (size_t k = 0; k < more; ++k) {
    averaged.vertices.push_back(plan.centre +
                                Vec3(coordinate(generator), coordinate(generator), coordinate(generator)));
    averaged.sigma_mm.push_back(1);
    averaged.ray.push_back(Vec3::Zero());
  }
  triangulation.add(std::span(averaged.vertices).last(more));
  const auto after = triangulation.tetrahedra();
  ASSERT_TRUE(after.ok());
  const auto anew = delaunay(averaged.vertices);
  ASSERT_TRUE(anew.ok());
  ASSERT_EQ(after->cells.size(), anew->cells.size());
  const Visibility wanted = vote_visibility(*anew, scan, averaged);
  const Visibility again = vote_again(*after, scan, averaged, *before, votes_before);
  EXPECT_EQ(again.rays_walked, wanted.rays_walked);
  EXPECT_EQ(again.rays_lost, 0u);
  EXPECT_EQ(again.crossed, wanted.crossed);
  for (size_t c = 0; c < wanted.cells.size(); ++c) {
    ASSERT_EQ(after->cells[c].vertex, anew->cells[c].vertex);
    const CellVotes &a = again.cells[c], &w = wanted.cells[c];
    ASSERT_EQ(a.entered_through, w.entered_through) << "cell " << c;
    ASSERT_EQ(std::tuple(a.from_outside, a.into_inside, a.air, a.solid),
              std::tuple(w.from_outside, w.into_inside, w.air, w.solid))
        << "cell " << c;
  }
}

TEST(VoteAgain, GivesTheVotesOfAllRaysWalkedAnew) {
  expect_same_votes(1, 8);
  expect_same_votes(60, 8);
}

TEST(VoteAgain, AlsoWhereTheHullGrows) {
  expect_same_votes(60, 25);
}

TEST(ChangedCells, NothingIsNewWhereNothingWasAdded) {
  const auto cells = delaunay(std::vector<Vec3>{{0, 0, 0}, {4, 0, 0}, {0, 5, 0}, {0, 0, 6}, {4, 5, 7}});
  ASSERT_TRUE(cells.ok());
  const ChangedCells changed(*cells, *cells);
  for (uint32_t c = 0; c < cells->cells.size(); ++c) EXPECT_EQ(changed.number_before()[c], c);
  EXPECT_FALSE(changed.may_be_on(Vec3(-9, 1, 1), Vec3(9, 1, 1)));
}

}  // namespace
}  // namespace tetragauge
