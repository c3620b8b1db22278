// SPDX-License-Identifier: GPL-3.0-or-later
// STEP files of other people, against what is known of them (shared/data/SOURCES.md).
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "host/solid/ray_caster.hpp"
#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

using test::count;
using test::error_of;

std::filesystem::path shared_step(const std::string& name) {
  return std::filesystem::path(TETRAGAUGE_SHARED_DATA) / "step" / name;
}

struct Part {
  const char* file;
  const char* unit;
  // Faces by type after merging; SOURCES.md counts them as the file splits them.
  int plane, cylinder, cone, sphere, torus, other;
  Vec3 extent_mm;  // of SOURCES.md (its vertices), in mm; nil where round faces reach beyond the vertices
};

void PrintTo(const Part& part, std::ostream* out) {
  *out << part.file;
}

constexpr double kInch = 25.4;

const std::vector<Part>& parts() {
  static const std::vector<Part> kParts{
      {"nist/nist_ctc_01_asme1_rd.stp", "mm", 80, 57, 2, 0, 0, 0, {800, 450, 150}},
      // 117 in the file: ten holes' cylinders and two countersinks are given as halves.
      {"nist/nist_ctc_01_asme1_ap242-e1.stp", "mm", 56, 47, 2, 0, 0, 0, {800, 450, 150}},
      {"nist/nist_ctc_03_asme1_rc.stp", "inch", 86, 53, 0, 0, 0, 0, Vec3::Zero()},
      // 209 in the file: one plane is a free surface beside the solid; 33 cylinders, 13 cones and a torus are
      // given as halves.
      {"nist/nist_ctc_05_asme1_rd.stp", "inch", 62, 67, 13, 4, 6, 9, Vec3::Zero()},
      {"nist/nist_ftc_06_asme1_rd.stp", "inch", 71, 58, 4, 5, 6, 0, kInch * Vec3(12, 3.85, 9.75)},
      // 270 in the file: 23 holes' cylinders are given as halves.
      {"nist/nist_ftc_08_asme1_rc.stp", "inch", 81, 134, 0, 20, 12, 0, Vec3::Zero()},
      {"nist/nist_ftc_10_asme1_rb.stp", "mm", 53, 103, 8, 10, 39, 1, Vec3::Zero()},
      {"nist/nist_ftc_11_asme1_rb.stp", "mm", 2, 2, 0, 0, 2, 0, Vec3::Zero()},
      {"scannersim/FlatTargetv3.step", "mm", 26, 4, 8, 0, 0, 0, {150, 150, 10}},
      {"scannersim/RookTargetv12.step", "inch", 20, 30, 40, 0, 22, 0, Vec3::Zero()},
      {"occwl/Block_hole.step", "mm", 7, 1, 0, 0, 0, 0, {50, 50, 30}},
      {"occwl/four_cone.step", "mm", 6, 0, 4, 0, 0, 0, {100, 50, 50}},
      {"occwl/face_3_loops.step", "mm", 19, 1, 0, 0, 0, 0, {150, 50, 40}},
      {"occwl/block_torus_fillet3.step", "mm", 6, 3, 0, 0, 0, 1, {50, 50, 40}},
      {"occwl/polygon_35_side.step", "mm", 37, 0, 0, 0, 0, 0, Vec3::Zero()},
      {"occwl/118539_1dff9cf9_6.stp", "cm", 7, 5, 0, 0, 0, 0, {20, 5, 15.03}},
      // 8 in the file: two of the cylinders are given as halves.
      {"occwl/0153_003_final.step", "mm", 3, 3, 0, 0, 0, 0, Vec3::Zero()},
      // 96 in the file: 17 holes' cylinders are given as halves.
      {"trimesh/featuretype.STEP", "inch", 49, 29, 0, 0, 0, 1, kInch * Vec3(5, 2.5, 1.375)},
      // 30 in the file: 7 holes' cylinders are given as halves.
      {"trimesh/base_interface_AP203.STEP", "inch", 8, 15, 0, 0, 0, 0, Vec3::Zero()},
      {"trimesh/base_interface_AP214.STEP", "inch", 8, 15, 0, 0, 0, 0, Vec3::Zero()},
      {"occt_import_js/conical-surface.step", "inch", 2, 2, 1, 0, 0, 0, Vec3::Zero()},
      {"occt_import_js/cube-in.step", "inch", 6, 0, 0, 0, 0, 0, {1000, 1000, 1000}},
      {"occt_import_js/cube-m.step", "m", 6, 0, 0, 0, 0, 0, {1000, 1000, 1000}},
      {"occt_import_js/cube-mm.step", "mm", 6, 0, 0, 0, 0, 0, {1000, 1000, 1000}},
      {"pythonocc/face_recognition_sample_part.stp", "mm", 17, 6, 0, 0, 0, 0, {315, 105, 225}},
  };
  return kParts;
}

double volume_of_triangles(const Solid& solid) {
  double volume = 0;
  const Vec3& o = solid.centroid_mm;
  for (const auto& t : solid.triangles) {
    volume += (solid.vertices[t[0]] - o).dot((solid.vertices[t[1]] - o).cross(solid.vertices[t[2]] - o)) / 6;
  }
  return volume;
}

class StepFile : public testing::TestWithParam<Part> {};

TEST_P(StepFile, HasTheKnownFacesAndUnit) {
  const Part& part = GetParam();
  const std::filesystem::path path = shared_step(part.file);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; the folder shared is optional";
  testing::internal::CaptureStdout();
  Result<Solid> solid = read_solid(path);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "") << "stdout is data";
  ASSERT_TRUE(solid) << solid.error().message;
  EXPECT_EQ(solid->declared_unit, part.unit);
  EXPECT_EQ(count(*solid, SurfaceType::plane), part.plane);
  EXPECT_EQ(count(*solid, SurfaceType::cylinder), part.cylinder);
  EXPECT_EQ(count(*solid, SurfaceType::cone), part.cone);
  EXPECT_EQ(count(*solid, SurfaceType::sphere), part.sphere);
  EXPECT_EQ(count(*solid, SurfaceType::torus), part.torus);
  EXPECT_EQ(count(*solid, SurfaceType::other), part.other);
  if (!part.extent_mm.isZero()) {
    EXPECT_LT((solid->box_max_mm - solid->box_min_mm - part.extent_mm).cwiseAbs().maxCoeff(), 0.01);
  }
  for (const std::string& warning : solid->warnings)
    EXPECT_EQ(warning.find("do not close"), std::string::npos) << warning;
  // Two ways to the volume that share nothing but the shape.
  EXPECT_NEAR(volume_of_triangles(*solid), solid->volume_mm3, 0.02 * solid->area_mm2);
  // Equations are outward: a little along a plane's normal from an own triangle is further from the material.
  std::vector<double> area(solid->faces().size());
  for (size_t i = 0; i < solid->triangles.size(); ++i) {
    const auto& t = solid->triangles[i];
    const Face& face = solid->faces()[solid->triangle_face[i]];
    const Vec3 &a = solid->vertices[t[0]], &b = solid->vertices[t[1]], &c = solid->vertices[t[2]];
    const Vec3 normal = (b - a).cross(c - a);
    area[solid->triangle_face[i]] += 0.5 * normal.norm();
    if (face.type != SurfaceType::torus && face.type != SurfaceType::other) {
      // Corners on an edge lie on the file's edge curve, which the file's own tolerance lets off the surface.
      ASSERT_NEAR(distance_to_surface(face, a), 0, ReadSolidOptions().tessellation_mm) << "face " << face.id;
      ASSERT_TRUE(face.type != SurfaceType::plane || normal.dot(face.normal) >= 0) << "face " << face.id;
    }
  }
  for (const Face& face : solid->faces()) {
    EXPECT_NEAR(area[static_cast<size_t>(face.id) - 1], face.area_mm2, 0.02 * face.area_mm2 + 0.1)
        << "face " << face.id;
    EXPECT_FALSE(face.neighbours.empty()) << "face " << face.id;
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, StepFile, testing::ValuesIn(parts()), [](const auto& info) {
  std::string name = std::filesystem::path(info.param.file).filename().string();
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

TEST(Step, EqualCubesInThreeUnits) {
  for (const char* file : {"cube-in.step", "cube-m.step", "cube-mm.step"}) {
    const std::filesystem::path path = shared_step("occt_import_js") / file;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; the folder shared is optional";
    Result<Solid> solid = read_solid(path);
    ASSERT_TRUE(solid) << solid.error().message;
    EXPECT_NEAR(solid->volume_mm3, 1e9, 1);
    EXPECT_TRUE(solid->warnings.empty());
  }
}

TEST(Step, SuspiciousUnitIsAWarning) {
  const std::filesystem::path path = shared_step("occt_import_js/as1_pe_203.stp");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; the folder shared is optional";
  Result<Solid> solid = read_solid(path);
  ASSERT_TRUE(solid) << solid.error().message;
  ASSERT_EQ(solid->warnings.size(), 1u);
  EXPECT_NE(solid->warnings[0].find("declared unit inch"), std::string::npos);
}

TEST(Step, AnAssemblysPartsStandAtAllTheirPlaces) {
  // The assembly of the CAx-IF's first test round: a plate, a rod with two nuts, and two brackets with three
  // bolts and nuts each. Its numbers are mm, though it declares inch.
  const std::filesystem::path path = shared_step("occt_import_js/as1_pe_203.stp");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; the folder shared is optional";
  Result<Solid> solid = read_solid(path);
  ASSERT_TRUE(solid) << solid.error().message;
  EXPECT_EQ(solid->solids, 1 + 1 + 2 + 2 * (1 + 3 + 3));
  // Each bolt's shank is a convex cylinder; six bolts at six places have six axes.
  std::map<int64_t, std::vector<Vec3>> axes;  // of convex cylinders, by radius
  for (const Face& face : solid->faces()) {
    if (face.type != SurfaceType::cylinder || face.concave) continue;
    std::vector<Vec3>& own = axes[std::llround(1e3 * face.radius_mm)];
    const auto is_same = [&](const Vec3& p) {
      return face.axis.cross(p - face.point_on_axis_mm).norm() < 1e-6;
    };
    if (std::none_of(own.begin(), own.end(), is_same)) own.push_back(face.point_on_axis_mm);
  }
  const auto has_six = [](const auto& entry) { return entry.second.size() == 6; };
  EXPECT_TRUE(std::any_of(axes.begin(), axes.end(), has_six));
  EXPECT_NEAR(volume_of_triangles(*solid), solid->volume_mm3, 0.02 * solid->area_mm2);
}

TEST(Step, BlockWithAHoleHasTheAnalyticVolume) {
  const std::filesystem::path path = shared_step("occwl/Block_hole.step");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; the folder shared is optional";
  Result<Solid> solid = read_solid(path);
  ASSERT_TRUE(solid) << solid.error().message;
  const Face& hole = solid->faces().back();
  ASSERT_EQ(hole.type, SurfaceType::cylinder);
  EXPECT_TRUE(hole.concave);
  const double depth = hole.area_mm2 / (2 * std::numbers::pi * hole.radius_mm);
  // A blind or through hole in a block of 50 x 50 x 30.
  EXPECT_NEAR(solid->volume_mm3, 50 * 50 * 30 - std::numbers::pi * hole.radius_mm * hole.radius_mm * depth,
              1e-6);
}

TEST(Step, TheSamePartInTwoSchemasIsTheSame) {
  const auto read = [](const char* name) { return read_solid(shared_step(name)); };
  if (!std::filesystem::exists(shared_step("trimesh"))) GTEST_SKIP() << "the folder shared is optional";
  Result<Solid> a = read("trimesh/base_interface_AP203.STEP"), b = read("trimesh/base_interface_AP214.STEP");
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->faces().size(), b->faces().size());
  for (size_t i = 0; i < a->faces().size(); ++i) {
    EXPECT_EQ(a->faces()[i].type, b->faces()[i].type);
    EXPECT_NEAR(a->faces()[i].area_mm2, b->faces()[i].area_mm2, 1e-6);
    EXPECT_LT((a->faces()[i].point_mm - b->faces()[i].point_mm).norm(), 1e-6);
    EXPECT_EQ(a->faces()[i].neighbours, b->faces()[i].neighbours);
  }
}

TEST(Step, WhatIsNotStepIsABadInput) {
  EXPECT_NE(error_of("solid cube\nfacet normal 0 0 1\n", ".step").find("not a STEP file"), std::string::npos);
  EXPECT_NE(error_of("", ".stp").find("not a STEP file"), std::string::npos);
  EXPECT_NE(error_of("ISO-10303-21;\nHEADER;\n", ".stp").find("ends early"), std::string::npos);
  EXPECT_NE(
      error_of("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=NONSENSE((;\nENDSEC;\nEND-ISO-10303-21;\n", ".stp")
          .find("tetragauge_"),
      std::string::npos);
  const auto missing = read_solid("/nowhere/part.step");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::bad_input);
  const auto other = read_solid("part.iges");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find(".iges"), std::string::npos);
}

TEST(Step, AFileCutShortOrWithoutAFaceIsABadInput) {
  const std::filesystem::path path = shared_step("occt_import_js/cube-mm.step");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; the folder shared is optional";
  std::ifstream file(path, std::ios::binary);
  std::stringstream content;
  content << file.rdbuf();
  std::string text = content.str();
  EXPECT_NE(error_of(text.substr(0, text.size() / 2), ".step").find("ends early"), std::string::npos);
  // Without one of the shell's faces the cube is open.
  const size_t shell = text.find("CLOSED_SHELL");
  ASSERT_NE(shell, std::string::npos);
  const size_t first = text.find("(#", text.find(',', shell)), comma = text.find(',', first);
  text.erase(first + 1, comma - first);
  EXPECT_NE(error_of(text, ".step").find("open"), std::string::npos) << error_of(text, ".step");
}

}  // namespace
}  // namespace tetragauge
