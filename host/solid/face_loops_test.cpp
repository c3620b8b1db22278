// SPDX-License-Identifier: GPL-3.0-or-later
// Boundaries against the definition of the bodies, and the area inside them against the kernel's integrals.
#include "host/solid/face_loops.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

using test::solid_from_csg;
constexpr double kPi = std::numbers::pi;

struct Bounded {
  Solid solid;
  std::vector<std::vector<FaceLoop>> loops;
  explicit Bounded(Solid model) : solid(std::move(model)), loops(face_loops(solid)) {}
};

Vec3 end_of(const FaceLoop& loop, size_t i) {
  return loop[(i + 1) % loop.size()].corner_mm;
}

// Angle that an edge on a circle turns through, in (0, 2 pi].
double turn_of(const LoopEdge& edge, const Vec3& end) {
  const Vec3 a = edge.corner_mm - edge.circle->centre_mm, b = end - edge.circle->centre_mm;
  if ((a - b).norm() < 1e-9) return 2 * kPi;
  const double turn = std::atan2(edge.circle->axis.dot(a.cross(b)), a.dot(b));
  return turn > 0 ? turn : turn + 2 * kPi;
}

// Twice the area inside the edge of a plane by Green's theorem: half the integral of (p x dp) . n, which an
// arc adds c . (r (end - start) x n) and r^2 turn to. Exact for lines and circles.
double green(const LoopEdge& edge, const Vec3& end, const Vec3& n, const Vec3& o) {
  if (edge.circle) {
    const Vec3 c = edge.circle->centre_mm - o;
    const double radius = edge.circle->radius_mm, side = edge.circle->axis.dot(n);
    return n.dot(c.cross(end - edge.corner_mm)) + side * radius * radius * turn_of(edge, end);
  }
  double twice = 0;
  Vec3 from = edge.corner_mm;
  for (const Vec3& p : edge.points_mm) {
    twice += n.dot((from - o).cross(p - from));
    from = p;
  }
  return twice + n.dot((from - o).cross(end - from));
}

double length_of(const LoopEdge& edge, const Vec3& end) {
  if (edge.circle) return edge.circle->radius_mm * turn_of(edge, end);
  double length = 0;
  Vec3 from = edge.corner_mm;
  for (const Vec3& p : edge.points_mm) {
    length += (p - from).norm();
    from = p;
  }
  return length + (end - from).norm();
}

// What must hold of any closed body: faces beyond are the neighbours, planes have their area inside their
// boundary, and two faces have as much of an edge as each other.
void expect_sound(const Bounded& body, double chord_mm) {
  std::map<std::pair<int, int>, double> sides;  // by face and the one beyond
  for (size_t i = 0; i < body.loops.size(); ++i) {
    const Face& face = body.solid.faces()[i];
    std::set<int> beyond;
    double twice_area = 0, curved_mm = 0;
    for (const FaceLoop& loop : body.loops[i]) {
      for (size_t k = 0; k < loop.size(); ++k) {
        const LoopEdge& edge = loop[k];
        const Vec3 end = end_of(loop, k);
        beyond.insert(edge.beyond);
        twice_area += green(edge, end, face.normal, face.point_mm);
        const double length = length_of(edge, end);
        if (!edge.is_line && !edge.circle) curved_mm += length;
        sides[{face.id, edge.beyond}] += length;
        if (!edge.is_line) {
          ASSERT_FALSE(edge.points_mm.empty()) << "face " << face.id;
        }
      }
    }
    EXPECT_EQ(std::vector<int>(beyond.begin(), beyond.end()), face.neighbours) << "face " << face.id;
    if (face.type == SurfaceType::plane) {
      EXPECT_NEAR(twice_area / 2, face.area_mm2, 1e-6 * face.area_mm2 + chord_mm * curved_mm)
          << "face " << face.id;
    }
  }
  for (const auto& [pair, length] : sides) {
    EXPECT_NEAR(length, sides[std::pair(pair.second, pair.first)], 1e-6 * length)
        << pair.first << " | " << pair.second;
  }
}

TEST(FaceLoops, BoxHasItsTwelveEdgesTwice) {
  const Bounded box(solid_from_csg("cube(size = [10, 20, 30], center = false);"));
  expect_sound(box, 0);
  int edges = 0;
  for (size_t i = 0; i < 6; ++i) {
    ASSERT_EQ(box.loops[i].size(), 1u);
    ASSERT_EQ(box.loops[i][0].size(), 4u);
    for (size_t k = 0; k < 4; ++k) {
      const LoopEdge& edge = box.loops[i][0][k];
      EXPECT_TRUE(edge.is_line);
      const Vec3 along = end_of(box.loops[i][0], k) - edge.corner_mm;
      // The face lies to the left of its edges, and the other face's plane holds both ends.
      EXPECT_GT(box.solid.faces()[i].normal.cross(along).dot(box.solid.faces()[i].point_mm - edge.corner_mm),
                0);
      const Face& other = box.solid.faces()[static_cast<size_t>(edge.beyond) - 1];
      EXPECT_NEAR(other.normal.dot(edge.corner_mm), other.d_mm, 1e-12);
      EXPECT_NEAR(other.normal.dot(edge.corner_mm + along), other.d_mm, 1e-12);
      ++edges;
    }
  }
  EXPECT_EQ(edges, 24);
}

TEST(FaceLoops, CylinderConeAndSphereEndInCircles) {
  // From z = 0, radius 8, to z = 10, radius 3.
  const Bounded cone(solid_from_csg("cylinder($fn = 0, h = 10, r1 = 8, r2 = 3, center = false);"));
  expect_sound(cone, 0);
  for (size_t i = 0; i < 3; ++i) {
    const Face& face = cone.solid.faces()[i];
    ASSERT_EQ(cone.loops[i].size(), face.type == SurfaceType::plane ? 1u : 2u);
    for (const FaceLoop& loop : cone.loops[i]) {
      ASSERT_EQ(loop.size(), 1u);
      ASSERT_TRUE(loop[0].circle);
      const bool is_top = loop[0].corner_mm.z() > 5;
      EXPECT_NEAR(loop[0].circle->radius_mm, is_top ? 3 : 8, 1e-9);
      EXPECT_LT((loop[0].circle->centre_mm - Vec3(0, 0, is_top ? 10 : 0)).norm(), 1e-9);
      // Round the top the end face runs counter-clockwise about +z and the side the other way; below
      // mirrored.
      const double way = (face.type == SurfaceType::plane) == is_top ? 1 : -1;
      EXPECT_NEAR(loop[0].circle->axis.z(), way, 1e-12);
      for (const Vec3& p : loop[0].points_mm)
        EXPECT_NEAR((p - loop[0].circle->centre_mm).norm(), loop[0].circle->radius_mm, 1e-9);
    }
  }
  const Bounded cap(
      solid_from_csg("intersection() { sphere($fn = 0, r = 10);\n"
                     "  multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 6], [0, 0, 0, 1]]) {\n"
                     "    cylinder($fn = 0, h = 20, r1 = 30, r2 = 30, center = false); } }"));
  expect_sound(cap, 0);
  ASSERT_EQ(cap.loops.size(), 2u);
  EXPECT_NEAR(cap.loops[0][0][0].circle->radius_mm, 8, 1e-9);  // 10^2 - 6^2
  EXPECT_NEAR(cap.loops[1][0][0].circle->radius_mm, 8, 1e-9);
  const Bounded ball(solid_from_csg("sphere($fn = 0, r = 10);"));
  EXPECT_TRUE(ball.loops[0].empty());
}

TEST(FaceLoops, PlateWithHolesAndASlot) {
  // A slot whose ends are half circles of 4 mm, and three round holes.
  const Bounded plate(solid_from_csg(
      "difference() { cube(size = [100, 40, 5], center = true);\n"
      "  linear_extrude(height = 20, center = true, $fn = 0) { union() {\n"
      "    square(size = [20, 8], center = true);\n"
      "    multmatrix([[1,0,0,10],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { circle($fn = 0, r = 4); }\n"
      "    multmatrix([[1,0,0,-10],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { circle($fn = 0, r = 4); } "
      "} }\n"
      "  multmatrix([[1,0,0,-35],[0,1,0,5],[0,0,1,0],[0,0,0,1]]) { cylinder($fn = 0, h = 9, r1 = "
      "6, r2 = 6, center = true); }\n"
      "  multmatrix([[1,0,0,35],[0,1,0,5],[0,0,1,0],[0,0,0,1]]) { cylinder($fn = 0, h = 9, r1 = 3, "
      "r2 = 3, center = true); }\n"
      "  multmatrix([[1,0,0,35],[0,1,0,-8],[0,0,1,0],[0,0,0,1]]) { cylinder($fn = 0, h = 9, r1 = "
      "2, r2 = 5, center = true); } }"));
  expect_sound(plate, 0);
  int tops = 0;
  for (size_t i = 0; i < plate.loops.size(); ++i) {
    const Face& face = plate.solid.faces()[i];
    if (face.type != SurfaceType::plane || std::abs(face.normal.z()) < 0.5) continue;
    ++tops;
    ASSERT_EQ(plate.loops[i].size(), 5u);
    EXPECT_EQ(plate.loops[i][0].size(), 4u) << "the outer loop is first";
    std::multiset<int64_t> radii;
    for (size_t k = 1; k < 5; ++k) {
      for (const LoopEdge& edge : plate.loops[i][k]) {
        if (!edge.circle) continue;
        radii.insert(std::llround(1e6 * edge.circle->radius_mm));
        EXPECT_LT(edge.circle->axis.dot(face.normal), 0) << "holes run clockwise";
      }
    }
    // The cone's radius at z = +-2.5, half a plate, of 9 mm of height from 2 to 5.
    const double cone = 3.5 + 3 * (face.normal.z() > 0 ? 2.5 : -2.5) / 9;
    EXPECT_EQ(radii, (std::multiset<int64_t>{3000000, 4000000, 4000000, 6000000, std::llround(1e6 * cone)}));
  }
  EXPECT_EQ(tops, 2);
}

TEST(FaceLoops, ObliqueCutsAreCurvesWithinTheirChords) {
  // A cylinder of radius 10 cut at 45 degrees: an ellipse of semi-axes 10 and 10 sqrt 2.
  const Bounded cut(solid_from_csg(
      "difference() { cylinder($fn = 0, h = 60, r1 = 10, r2 = 10, center = false);\n"
      "  multmatrix([[0.707107, 0, 0.707107, 0], [0, 1, 0, 0], [-0.707107, 0, 0.707107, 30], [0, "
      "0, 0, 1]]) {\n"
      "    multmatrix([[1,0,0,0],[0,1,0,0],[0,0,1,50],[0,0,0,1]]) { cube(size = [100, 100, 100], "
      "center = true); } } }"));
  int ellipses = 0;
  for (size_t i = 0; i < cut.loops.size(); ++i) {
    for (const FaceLoop& loop : cut.loops[i]) {
      if (loop[0].circle) continue;
      ++ellipses;
      EXPECT_FALSE(loop[0].is_line);
      for (const Vec3& p : loop[0].points_mm) {
        EXPECT_NEAR(std::hypot(p.x(), p.y()), 10, 1e-6);
        EXPECT_NEAR(p.x() + p.z(), 30, 1e-6);
      }
      // Ramanujan's second formula, Modular equations and approximations to pi (1914), exact to 1e-7 here.
      const double a = 10 * std::numbers::sqrt2, b = 10, h = std::pow((a - b) / (a + b), 2);
      const double perimeter = kPi * (a + b) * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
      EXPECT_LT(length_of(loop[0], loop[0].corner_mm), perimeter + 1e-6);
      EXPECT_GT(length_of(loop[0], loop[0].corner_mm), perimeter * (1 - 0.003));
    }
  }
  EXPECT_EQ(ellipses, 2);  // of the cut and of the side
}

TEST(FaceLoops, StaircaseAndMeshesAreSound) {
  expect_sound(Bounded(solid_from_csg(test::kStaircase)), 0);
  const std::string obj =
      "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nv 0 0 5\nv 9 0 5\nv 9 9 5\nv 0 9 5\nv 4 4 5\n"
      "f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 9\nf 6 7 9\nf 7 8 9\nf 8 5 9\n";
  Result<Solid> box = test::read_text(obj, ".obj");
  ASSERT_TRUE(box) << box.error().message;
  const Bounded mesh(std::move(box).value());
  expect_sound(mesh, 0);
  for (const auto& loops : mesh.loops) {
    ASSERT_EQ(loops.size(), 1u);
    EXPECT_EQ(loops[0].size(), 4u);
  }
}

TEST(FaceLoops, PartsOfOthersAreSound) {
  const std::filesystem::path folder = TETRAGAUGE_SHARED_DATA;
  for (const char* file :
       {"step/nist/nist_ctc_01_asme1_rd.stp", "step/nist/nist_ctc_03_asme1_rc.stp",
        "step/nist/nist_ftc_06_asme1_rd.stp", "step/nist/nist_ftc_11_asme1_rb.stp",
        "step/scannersim/FlatTargetv3.step", "step/occwl/Block_hole.step", "step/occwl/four_cone.step",
        "step/occwl/face_3_loops.step", "step/occwl/118539_1dff9cf9_6.stp",
        "step/occwl/block_torus_fillet3.step", "step/trimesh/featuretype.STEP",
        "step/pythonocc/face_recognition_sample_part.stp", "mesh_cad/trimesh/plate_holes.STL"}) {
    SCOPED_TRACE(file);
    if (!std::filesystem::exists(folder / file))
      GTEST_SKIP() << folder / file << " is not here; the folder shared is optional";
    Result<Solid> solid = read_solid(folder / file);
    ASSERT_TRUE(solid) << solid.error().message;
    expect_sound(Bounded(std::move(solid).value()), ReadSolidOptions().tessellation_mm);
  }
}

}  // namespace
}  // namespace tetragauge
