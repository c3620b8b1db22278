// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/display_mesh.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <numbers>

namespace tetragauge {
namespace {

// A 40 x 30 rectangle in the plane z = 0, face 0, and a strip of `strips` thin triangles bent about the y
// axis, face 1.
Solid rectangle_and_arc(uint32_t strips) {
  Solid solid;
  solid.vertices = {{0, 0, 0}, {40, 0, 0}, {40, 30, 0}, {0, 30, 0}};
  solid.triangles = {{0, 1, 2}, {0, 2, 3}};
  solid.triangle_face = {0, 0};
  for (uint32_t k = 0; k <= strips; ++k) {
    const double angle = std::numbers::pi / 2 * k / strips;
    for (const double y : {0.0, 30.0})
      solid.vertices.emplace_back(10 * std::sin(angle) + 40, y, 10 * (1 - std::cos(angle)));
    if (k == 0) continue;
    const uint32_t a = 4 + 2 * (k - 1);
    solid.triangles.insert(solid.triangles.end(), {{a, a + 2, a + 1}, {a + 2, a + 3, a + 1}});
    solid.triangle_face.insert(solid.triangle_face.end(), {1, 1});
  }
  solid.area_mm2 = 40 * 30 + 10 * std::numbers::pi / 2 * 30;
  solid.box_max_mm = Vec3(50, 30, 10);
  return solid;
}

std::map<uint32_t, double> area_by_face(const DisplayMesh& mesh) {
  std::map<uint32_t, double> areas;
  for (const auto& [a, b, c] : mesh.triangles) {
    EXPECT_EQ(mesh.vertex_face[a], mesh.vertex_face[b]);
    EXPECT_EQ(mesh.vertex_face[a], mesh.vertex_face[c]);
    areas[mesh.vertex_face[a]] +=
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm() / 2;
  }
  return areas;
}

TEST(DisplayMesh, RefinesWithoutChangingTheSurface) {
  const Solid solid = rectangle_and_arc(8);
  const DisplayMesh mesh = display_mesh(solid, 5000);
  EXPECT_FALSE(mesh.is_coarser);
  EXPECT_LE(mesh.triangles.size(), 5000u);
  EXPECT_GT(mesh.triangles.size(), 1500u);
  const auto areas = area_by_face(mesh);
  EXPECT_NEAR(areas.at(0), 1200, 1e-9);
  EXPECT_NEAR(areas.at(1), 8 * 2 * 10 * std::sin(std::numbers::pi / 32) * 30, 1e-9);
  // No T-junctions: inside a face each edge has two triangles, run in opposite directions.
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3];
      ++uses[{a, b}];
      EXPECT_EQ((uses[{a, b}]), 1);
    }
  }
  double rim_mm = 0;
  for (const auto& [edge, count] : uses)
    if (!uses.contains({edge.second, edge.first}))
      rim_mm +=
          (mesh.vertices[static_cast<size_t>(edge.first)] - mesh.vertices[static_cast<size_t>(edge.second)])
              .norm();
  EXPECT_NEAR(rim_mm, 2 * (40 + 30) + 2 * 30 + 2 * 8 * 2 * 10 * std::sin(std::numbers::pi / 32), 1e-9);
}

TEST(DisplayMesh, MakesAFineTessellationCoarser) {
  // A closed cylinder, 30 high, 10 in radius, of far too many strips: faces bottom, top, side.
  constexpr uint32_t kStrips = 4000;
  Solid solid;
  solid.vertices = {{0, 0, 0}, {0, 0, 30}};
  for (uint32_t k = 0; k < kStrips; ++k) {
    const double angle = 2 * std::numbers::pi * k / kStrips;
    for (const double z : {0.0, 30.0})
      solid.vertices.emplace_back(10 * std::cos(angle), 10 * std::sin(angle), z);
  }
  for (uint32_t k = 0; k < kStrips; ++k) {
    const uint32_t a = 2 + 2 * k, b = 2 + 2 * ((k + 1) % kStrips);
    solid.triangles.insert(solid.triangles.end(),
                           {{0, b, a}, {1, a + 1, b + 1}, {a, b, b + 1}, {a, b + 1, a + 1}});
    solid.triangle_face.insert(solid.triangle_face.end(), {0, 1, 2, 2});
  }
  solid.area_mm2 = 2 * std::numbers::pi * (100 + 300);
  solid.box_min_mm = Vec3(-10, -10, 0);
  solid.box_max_mm = Vec3(10, 10, 30);
  const DisplayMesh mesh = display_mesh(solid, 1000);
  EXPECT_TRUE(mesh.is_coarser);
  EXPECT_LE(mesh.triangles.size(), 1000u);
  const auto areas = area_by_face(mesh);
  EXPECT_NEAR(areas.at(0), 100 * std::numbers::pi, 0.02 * 100 * std::numbers::pi);
  EXPECT_NEAR(areas.at(1), 100 * std::numbers::pi, 0.02 * 100 * std::numbers::pi);
  EXPECT_NEAR(areas.at(2), 600 * std::numbers::pi, 0.02 * 600 * std::numbers::pi);
  // Still closed, across its faces too: each edge is run as often one way as the other.
  using Place = std::array<double, 3>;
  std::map<std::pair<Place, Place>, int> balance;
  const auto place = [&](uint16_t v) {
    return Place{mesh.vertices[v].x(), mesh.vertices[v].y(), mesh.vertices[v].z()};
  };
  for (const auto& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const Place a = place(t[i]), b = place(t[(i + 1) % 3]);
      a < b ? ++balance[{a, b}] : --balance[{b, a}];
    }
  }
  for (const auto& [edge, count] : balance) EXPECT_EQ(count, 0);
}

TEST(DisplayMesh, ManyFacesOfFewTriangles) {
  // More faces than there may be vertices: something is drawn all the same, and it ends.
  Solid solid;
  for (uint32_t k = 0; k < 30000; ++k) {
    const Vec3 corner(k % 200, k / 200, 0);
    for (const Vec3& step : {Vec3(0, 0, 0), Vec3(0.9, 0, 0), Vec3(0, 0.9, 0)})
      solid.vertices.push_back(corner + step);
    solid.triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    solid.triangle_face.push_back(k);
  }
  solid.area_mm2 = 30000 * 0.405;
  solid.box_max_mm = Vec3(200, 150, 0);
  EXPECT_LE(display_mesh(solid).triangles.size(), 30000u);
}

}  // namespace
}  // namespace tetragauge
