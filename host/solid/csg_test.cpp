// SPDX-License-Identifier: GPL-3.0-or-later
// .csg text against volumes and areas worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

using std::numbers::pi;
using test::count;
using test::error_of;
using test::solid_from_csg;

void expect_volume_and_area(const Solid& solid, double volume_mm3, double area_mm2, double relative = 1e-9) {
  EXPECT_NEAR(solid.volume_mm3, volume_mm3, relative * volume_mm3);
  EXPECT_NEAR(solid.area_mm2, area_mm2, relative * area_mm2);
  EXPECT_TRUE(solid.warnings.empty()) << solid.warnings.front();
  double from_triangles = 0;
  for (const auto& t : solid.triangles) {
    from_triangles += solid.vertices[t[0]].dot(solid.vertices[t[1]].cross(solid.vertices[t[2]])) / 6;
  }
  // 0.02 mm chords on parts of 10 mm and more: triangles outward, none missing.
  EXPECT_NEAR(from_triangles, volume_mm3, 0.02 * area_mm2);
}

TEST(Csg, CubeHasSixOutwardPlanesInCanonicalOrder) {
  const Solid solid = solid_from_csg("cube(size = [10, 20, 30], center = false);");
  expect_volume_and_area(solid, 6000, 2200);
  ASSERT_EQ(solid.faces().size(), 6u);
  for (const Face& face : solid.faces()) {
    EXPECT_EQ(face.type, SurfaceType::plane);
    EXPECT_GT(face.normal.dot(face.point_mm - Vec3(5, 10, 15)), 0);
    EXPECT_NEAR(face.normal.dot(face.point_mm), face.d_mm, 1e-12);
    EXPECT_EQ(face.neighbours.size(), 4u);
  }
  EXPECT_EQ(solid.faces()[0].id, 1);
  EXPECT_TRUE(solid.faces()[0].normal.isApprox(Vec3(-1, 0, 0)));
  EXPECT_TRUE(solid.faces()[5].normal.isApprox(Vec3(1, 0, 0)));
  EXPECT_TRUE(solid.centroid_mm.isApprox(Vec3(5, 10, 15)));
  EXPECT_TRUE(solid.box_max_mm.isApprox(Vec3(10, 20, 30)));
}

TEST(Csg, TheBoxIsThatOfTheRoundSurface) {
  // A rod of radius 10 and length 30 along (-0.8, 0, 0.6) from (3, 4, 5): along x 30 x 0.8 and a disc seen at
  // sine 0.6 at both ends, along y the disc alone, along z 30 x 0.6 and the disc at sine 0.8. No vertex of
  // its triangles need lie out there.
  const Solid solid = solid_from_csg(
      "multmatrix([[0.36, 0.48, -0.8, 3], [-0.8, 0.6, 0, 4], [0.48, 0.64, 0.6, 5], [0, 0, 0, 1]]) {\n"
      "  cylinder($fn = 0, h = 30, r1 = 10, r2 = 10, center = false); }");
  EXPECT_LT((solid.box_min_mm - Vec3(3 - 24 - 6, 4 - 10, 5 - 8)).norm(), 1e-6);
  EXPECT_LT((solid.box_max_mm - Vec3(3 + 6, 4 + 10, 5 + 18 + 8)).norm(), 1e-6);
}

TEST(Csg, StaircaseOfTheThesisHasFifteenFacesOnFourteenSurfaces) {
  const Solid solid = solid_from_csg(test::kStaircase);
  // 80 x 20 + 60 x 20 + 40 x 10 + 20 x 10, less the triangle 30 x 30 / 2, all 60 deep.
  expect_volume_and_area(
      solid, (1600 + 1200 + 400 + 200 - 450) * 60.0,
      2 * 2950.0 + 60 * (80 + 20 + 20 + 20 + 20 + 10 + 20 + 10 + 20 + 20 + 30 * std::sqrt(2.0) + 30 + 10));
  EXPECT_EQ(solid.faces().size(), 15u);
  int surfaces = 0;
  for (const Face& face : solid.faces()) surfaces = std::max(surfaces, face.surface);
  EXPECT_EQ(surfaces, 14);
}

TEST(Csg, RoundPrimitivesAreTrulyRound) {
  expect_volume_and_area(solid_from_csg("cylinder($fn = 0, h = 20, r1 = 5, r2 = 5, center = false);"),
                         pi * 25 * 20, 2 * pi * 25 + 2 * pi * 5 * 20);
  expect_volume_and_area(solid_from_csg("cylinder($fn = 100, h = 12, r1 = 5, r2 = 0, center = true);"),
                         pi * 25 * 12 / 3, pi * 25 + pi * 5 * 13);
  expect_volume_and_area(solid_from_csg("cylinder($fn = 0, h = 4, r1 = 5, r2 = 2);"),
                         pi * 4 / 3 * (25 + 10 + 4), pi * 29 + pi * 7 * 5);
  expect_volume_and_area(solid_from_csg("sphere($fn = 0, r = 10);"), 4 * pi * 1000 / 3, 400 * pi);
}

TEST(Csg, FewFacetsMakeAPrism) {
  const Solid prism = solid_from_csg("cylinder($fn = 6, h = 10, r1 = 4, r2 = 4, center = false);");
  expect_volume_and_area(prism, 1.5 * std::sqrt(3.0) * 16 * 10, 2 * 1.5 * std::sqrt(3.0) * 16 + 6 * 4 * 10);
  EXPECT_EQ(count(prism, SurfaceType::plane), 8);
  const Solid pyramid = solid_from_csg("cylinder($fn = 4, h = 3, r1 = 4, r2 = 0, center = false);");
  EXPECT_NEAR(pyramid.volume_mm3, 32 * 3 / 3.0, 1e-9);
  EXPECT_EQ(count(pyramid, SurfaceType::plane), 5);
}

TEST(Csg, DifferenceLeavesAConcaveCylinder) {
  const Solid solid = solid_from_csg(
      "difference() { cube(size = [40, 40, 10], center = true);\n"
      "  cylinder($fn = 0, h = 20, r1 = 5, r2 = 5, center = true); }");
  expect_volume_and_area(solid, 16000 - pi * 25 * 10, 2 * (1600 - 25 * pi) + 4 * 400 + 2 * pi * 5 * 10);
  ASSERT_EQ(count(solid, SurfaceType::cylinder), 1);
  const Face& hole = solid.faces().back();
  EXPECT_TRUE(hole.concave);
  EXPECT_NEAR(hole.radius_mm, 5, 1e-12);
  EXPECT_EQ(hole.neighbours.size(), 2u);
  EXPECT_NEAR(distance_to_surface(hole, Vec3(4, 0, 1)), 1, 1e-12);
}

TEST(Csg, UnionMergesFacesOfOnePlane) {
  const Solid solid = solid_from_csg(
      "cube(size = [10, 10, 10], center = false);\n"
      "multmatrix([[1, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {\n"
      "  cube(size = [5, 10, 10], center = false); }");
  expect_volume_and_area(solid, 1500, 2 * (150 + 150 + 100));
  EXPECT_EQ(solid.faces().size(), 6u);
}

TEST(Csg, SixDigitMatricesBecomeRotationsAgain) {
  // rotate([10, 20, 30]) as OpenSCAD prints it.
  const Solid solid = solid_from_csg(
      "multmatrix([[0.813798, -0.44097, 0.378522, 0], [0.469846, 0.882564, 0.0180283, 0], "
      "[-0.34202, 0.163176, 0.925417, 0], [0, 0, 0, 1]]) { cube(size = [100, 100, 100], center = false); }");
  EXPECT_NEAR(solid.volume_mm3, 1e6, 1e-6);
  const Mat3 R = rotation_from_degrees(10, 20, 30);
  for (int axis = 0; axis < 3; ++axis) {
    double best = 0;
    for (const Face& face : solid.faces()) best = std::max(best, face.normal.dot(R.col(axis)));
    EXPECT_GT(best, 1 - 1e-11);
  }
}

TEST(Csg, MirrorsAndUniformScalesKeepExactSurfaces) {
  const Solid solid = solid_from_csg(
      "multmatrix([[-2, 0, 0, 7], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]) {\n"
      "  difference() { cube(size = [10, 10, 10], center = false);\n"
      "    cylinder($fn = 0, h = 10, r1 = 3, r2 = 3, center = false); } }");
  expect_volume_and_area(solid, 8 * (1000 - pi * 9 / 4 * 10),
                         4 * (2 * (100 - pi * 9 / 4) + 2 * 100 + 2 * 70 + 1.5 * pi * 10));
  ASSERT_EQ(count(solid, SurfaceType::cylinder), 1);
  EXPECT_NEAR(solid.faces().back().radius_mm, 6, 1e-12);
  EXPECT_TRUE(solid.faces().back().concave);
}

TEST(Csg, ScaleAlongTheAxisKeepsACylinder) {
  const Solid solid = solid_from_csg(
      "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]]) {\n"
      "  cylinder($fn = 0, h = 10, r1 = 3, r2 = 3, center = true); }");
  expect_volume_and_area(solid, pi * 9 * 30, 2 * pi * 9 + 2 * pi * 3 * 30);
}

TEST(Csg, PolygonWithAHoleIsExtruded) {
  const Solid solid = solid_from_csg(
      "linear_extrude(height = 5, center = true, convexity = 1, scale = [1, 1], $fn = 0) {\n"
      "  polygon(points = [[0, 0], [10, 0], [10, 10], [0, 10], [2, 2], [4, 2], [4, 4], [2, 4]],\n"
      "          paths = [[0, 1, 2, 3], [4, 5, 6, 7]], convexity = 1); }");
  expect_volume_and_area(solid, 96 * 5, 2 * 96 + 48 * 5);
  EXPECT_EQ(solid.faces().size(), 10u);
  EXPECT_NEAR(solid.box_min_mm.z(), -2.5, 1e-12);
}

TEST(Csg, RoundOutlinesExtrudeToCylinders) {
  const Solid solid = solid_from_csg(
      "linear_extrude(height = 5, scale = [1, 1]) { difference() {\n"
      "  circle($fn = 0, r = 6); multmatrix([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {\n"
      "    circle($fn = 0, r = 2); } } }");
  expect_volume_and_area(solid, pi * 32 * 5, 2 * pi * 32 + 2 * pi * 8 * 5);
  EXPECT_EQ(count(solid, SurfaceType::cylinder), 2);
}

TEST(Csg, TurnedOutlines) {
  const char* const outline =
      "multmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [2, 3]); } }";
  const Solid ring = solid_from_csg(std::string("rotate_extrude(angle = 360, $fn = 0) {") + outline);
  expect_volume_and_area(ring, pi * (49 - 25) * 3, 2 * pi * 24 + 2 * pi * 12 * 3);
  EXPECT_EQ(count(ring, SurfaceType::cylinder), 2);
  const Solid quarter = solid_from_csg(std::string("rotate_extrude(angle = 90, $fn = 0) {") + outline);
  expect_volume_and_area(quarter, pi * 24 * 3 / 4, pi * 24 / 2 + pi * 12 * 3 / 2 + 2 * 6);
  const Solid square = solid_from_csg(std::string("rotate_extrude(angle = 360, $fn = 4) {") + outline);
  expect_volume_and_area(square, 2 * (49 - 25) * 3, 2 * 2 * 24 + 4 * std::sqrt(2.0) * 12 * 3);
  const Solid torus = solid_from_csg(
      "rotate_extrude($fn = 0) { multmatrix([[1, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {\n"
      "  circle($fn = 0, r = 3); } }");
  expect_volume_and_area(torus, 2 * pi * pi * 10 * 9, 4 * pi * pi * 30);
  EXPECT_EQ(count(torus, SurfaceType::torus), 1);
}

TEST(Csg, PolyhedronRunsEitherWayRound) {
  for (const char* faces :
       {"[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]", "[[2, 1, 0], [1, 3, 0], [3, 2, 0], [2, 3, 1]]"}) {
    const Solid solid = solid_from_csg(
        std::string("polyhedron(points = [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], faces = ") + faces +
        ");");
    expect_volume_and_area(solid, 36, 3 * 18 + 18 * std::sqrt(3.0));
  }
}

TEST(Csg, FacetedRingKeepsItsCavity) {
  const Solid solid = solid_from_csg(
      "rotate_extrude(angle = 360, $fn = 4) { difference() {\n"
      "  multmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [8, 12]); }\n"
      "  multmatrix([[1, 0, 0, 7], [0, 1, 0, 3], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [3, 4]); } } "
      "}");
  // Squares with corners at r have the area 2 r^2 and the circumference 4 sqrt(2) r.
  const double outside = 2 * 2 * (169 - 25) + 4 * std::sqrt(2.0) * 18 * 12;
  const double cavity = 2 * 2 * (100 - 49) + 4 * std::sqrt(2.0) * 17 * 4;
  expect_volume_and_area(solid, 2 * (169 - 25) * 12 - 2 * (100 - 49) * 4, outside + cavity);
  EXPECT_EQ(solid.solids, 1);
}

TEST(Csg, PartOfATurnHasOpenScadsSteps) {
  // 100 of 360 degrees of 7 steps: one whole step. OpenSCAD 2021.01 gives a volume of 135.4110 and an area of
  // 188.4293, as the trapezium from radius 3 to 8 over one step of 100 degrees must have.
  const Solid solid = solid_from_csg(
      "rotate_extrude(angle = 100, $fn = 7) {\n"
      "  multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [5, 5]); } }");
  const double angle = 100 * pi / 180, trapezium = 0.5 * (64 - 9) * std::sin(angle);
  expect_volume_and_area(solid, 5 * trapezium, 2 * trapezium + 2 * 25 + 2 * std::sin(angle / 2) * 11 * 5);
}

TEST(Csg, TurnedBoxesThatTouchMergeInSpiteOfSixDigits) {
  // As OpenSCAD prints rotate([10, 20, 30]) { cube([50, 40, 30]); translate([50, 0, 0]) cube([20, 40, 30]);
  // translate([0, 0, 30]) cube([70, 20, 10]); }: a prism of six sides.
  const std::string turn =
      "multmatrix([[0.813798, -0.44097, 0.378522, 0], [0.469846, 0.882564, 0.0180283, 0], "
      "[-0.34202, 0.163176, 0.925417, 0], [0, 0, 0, 1]]) {\n";
  const Solid solid = solid_from_csg(turn + "cube(size = [50, 40, 30]);\n" +
                                     "multmatrix([[1, 0, 0, 50], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) "
                                     "{ cube(size = [20, 40, 30]); }\n" +
                                     "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 30], [0, 0, 0, 1]]) "
                                     "{ cube(size = [70, 20, 10]); } }\n");
  EXPECT_EQ(solid.faces().size(), 8u);
  EXPECT_NEAR(solid.volume_mm3, 70 * 40 * 30 + 70 * 20 * 10, 1e-3);
}

TEST(Csg, AFlatUnionIsSweptAsOneBody) {
  const Solid solid = solid_from_csg(
      "linear_extrude(height = 4) { difference() { union() { square(size = [30, 10], center = false);\n"
      "  multmatrix([[1, 0, 0, 10], [0, 1, 0, 5], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [10, 15]); } "
      "}\n"
      "  multmatrix([[1, 0, 0, 12], [0, 1, 0, 8], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [2, 4]); } } "
      "}");
  EXPECT_EQ(solid.solids, 1);
  expect_volume_and_area(solid, (300 + 100 - 8) * 4.0, 2 * 392.0 + 4 * (100 + 12));
  EXPECT_EQ(solid.faces().size(), 2u + 8 + 4);
}

TEST(Csg, MarksOfOpenScad) {
  const Solid solid = solid_from_csg(
      "%cube(size = [1, 1, 1]);\n#cube(size = [2, 2, 2]);\n*sphere(r = 3);\n"
      "group();\ncolor([1, 0, 0, 1]) { render(convexity = 1) { group() { } } }");
  EXPECT_NEAR(solid.volume_mm3, 8, 1e-12);
}

TEST(Csg, SeparateBodiesAreSeveralSolids) {
  const Solid solid = solid_from_csg(
      "cube(size = [1, 1, 1]);\nmultmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {\n"
      "  cube(size = [2, 2, 2]); }");
  EXPECT_EQ(solid.solids, 2);
  EXPECT_NEAR(solid.volume_mm3, 9, 1e-12);
}

TEST(Csg, ErrorsNameFileLineAndCall) {
  const std::string unknown = error_of("cube(size = [1, 1, 1]);\n\nhull() {\n  cube(size = [1, 1, 1]);\n}\n");
  EXPECT_NE(unknown.find(".csg:3: 'hull' is not supported"), std::string::npos) << unknown;
  EXPECT_NE(error_of("linear_extrude(height = 1) {\n minkowski() { square(size = [1, 1]); } }")
                .find(":2: 'minkowski'"),
            std::string::npos);
  EXPECT_NE(error_of("cube(size = [1, 1, 1]").find("the file ends where ')'"), std::string::npos);
  EXPECT_NE(error_of("cube(size = [1, nan, 1]);").find("'nan' is not a value"), std::string::npos);
  EXPECT_NE(error_of("square(size = [1, 1]);").find("flat"), std::string::npos);
  EXPECT_NE(error_of("").find("empty"), std::string::npos);
  EXPECT_NE(error_of("linear_extrude(height = 1, twist = 5) { square(size = [1, 1]); }").find("twist"),
            std::string::npos);
  EXPECT_NE(error_of("multmatrix([[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {\n"
                     "  sphere($fn = 0, r = 2); }")
                .find(":2: sphere: scaled to an ellipsoid"),
            std::string::npos);
  EXPECT_NE(error_of("polyhedron(points = [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], "
                     "faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3]]);")
                .find("fewer than four"),
            std::string::npos);
  EXPECT_NE(error_of("linear_extrude(height = 1) { polygon(points = [[0, 0], [1, 1], [1, 0], [0, 1]]); }")
                .find("crosses itself"),
            std::string::npos);
}

TEST(Csg, NumbersBeyondAllPartsAreErrorsThatNameTheirLine) {
  const std::string huge =
      "multmatrix([[1e12, 0, 0, 0], [0, 1e12, 0, 0], [0, 0, 1e12, 0], [0, 0, 0, 1]]) {\n";
  EXPECT_NE(test::error_of(huge + huge + "cube(size = 1, center = false); } }").find(":2: multmatrix"),
            std::string::npos);
  EXPECT_NE(test::error_of("\nsphere($fn = 0, r = 1e300);").find(":2: sphere: 'r' must be"),
            std::string::npos);
  EXPECT_NE(test::error_of("cube(size = [1, 1, 1e16], center = false);").find("up to 1e15"),
            std::string::npos);
  // A name is quoted, not repeated.
  EXPECT_LT(test::error_of(std::string(5000, 'x') + "();").size(), 700u);
}

}  // namespace
}  // namespace tetragauge
