// SPDX-License-Identifier: GPL-3.0-or-later
// Matching with rays: what face lists alone cannot tell.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "host/match/match.hpp"
#include "host/simulate/simulate.hpp"

namespace tetragauge {
namespace {

Solid solid(const std::string& csg) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / (std::string("tetragauge_match_") + info->name() + ".csg");
  std::ofstream(path, std::ios::binary) << csg;
  Result<Solid> read = read_solid(path);
  std::filesystem::remove(path);
  if (!read) {
    ADD_FAILURE() << read.error().message;
    return {};
  }
  return std::move(read).value();
}

std::string block(const std::string& size, const std::string& at) {
  return "multmatrix([[1, 0, 0, " + at.substr(0, at.find(' ')) + "], [0, 1, 0, " +
         at.substr(at.find(' ') + 1, at.rfind(' ') - at.find(' ') - 1) + "], [0, 0, 1, " +
         at.substr(at.rfind(' ') + 1) + "], [0, 0, 0, 1]]) { cube(size = [" + size +
         "], center = false); }\n";
}

struct Simulated {
  Result<Match> match;
  RigidTransform error;  // of the chosen pose
};

const RigidTransform kPose{rotation_from_degrees(75, -35, 110), Vec3(-20, 40, 10)};

// The part as made may differ from the model.
Simulated match_simulated(const Solid& model, const Solid& part, size_t points, uint64_t seed,
                          const RigidTransform& T_scan_model = kPose) {
  const RayCaster caster(model);
  SimulateOptions options;
  options.points = points;
  options.seed = seed;
  options.T_scan_model = T_scan_model;
  Result<Scan> scan = simulate(part, RayCaster(part), options);
  EXPECT_TRUE(scan.ok());
  Result<Reconstruction> reconstruction = reconstruct(*scan);
  EXPECT_TRUE(reconstruction.ok());
  Result<MeasuredFaces> faces = find_faces(*scan, *reconstruction);
  EXPECT_TRUE(faces.ok());
  Simulated run{match_scan(model, caster, *scan, *faces), {}};
  EXPECT_TRUE(run.match.ok());
  if (run.match.ok()) run.error = run.match->T_model_part * options.T_scan_model;
  return run;
}

Simulated match_simulated(const Solid& model, size_t points, uint64_t seed) {
  return match_simulated(model, model, points, seed);
}

TEST(MatchScan, ACubeHas24Poses) {
  const Simulated run = match_simulated(solid("cube(size = [40, 40, 40], center = false);\n"), 6000, 1);
  EXPECT_EQ(run.match->equivalents.size(), 23u);
  EXPECT_EQ(run.match->pairs.size(), 6u);
}

TEST(MatchScan, RaysTellWhereASmallPocketIs) {
  // A square plate with a square pocket 8 mm off its middle: a face list knows the pocket's planes but not
  // their outlines.
  const Solid model = solid("difference() { cube(size = [60, 60, 15], center = false);\n" +
                            block("12, 12, 10", "32 24 10") + "}\n");
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const Simulated run = match_simulated(model, 8000, seed);
    EXPECT_TRUE(run.match->equivalents.empty()) << seed;
    EXPECT_LT(rotation_angle(run.error.R), 0.02 * std::numbers::pi / 180) << seed;
    EXPECT_LT((run.error * model.centroid_mm - model.centroid_mm).norm(), 0.02) << seed;
    EXPECT_TRUE(run.match->unmatched_measured.empty());
    EXPECT_GE(run.match->pairs.size(), 7u);  // the pocket's walls have some 30 points each: found or not
  }
}

TEST(MatchScan, APlateWithAllFourHolesOutOfPlaceIsNotTurnedOver) {
  // Its planes fit in four poses, and in none do the holes: in the true one they still contradict least.
  const auto plate = [](const std::vector<std::array<double, 3>>& holes) {
    std::string csg = "difference() { cube(size = [80, 60, 12], center = false);\n";
    for (const auto& [x, y, r] : holes)
      csg += "multmatrix([[1, 0, 0, " + std::to_string(x) + "], [0, 1, 0, " + std::to_string(y) +
             "], [0, 0, 1, -1], [0, 0, 0, 1]]) { cylinder($fn = 0, $fa = 12, $fs = 2, h = 14, r1 = " +
             std::to_string(r) + ", r2 = " + std::to_string(r) + ", center = false); }\n";
    return solid(csg + "}\n");
  };
  const Solid model = plate({{15, 12, 5}, {60, 15, 4}, {22, 45, 4}, {50, 40, 6}});
  const Solid part = plate({{18, 14, 5}, {57, 17, 4}, {25, 43, 4}, {47, 42, 6}});
  for (const Vec3& half_turn : {Vec3(0, 0, 0), Vec3(180, 0, 0), Vec3(0, 180, 0), Vec3(0, 0, 180)}) {
    const RigidTransform T{rotation_from_degrees(half_turn.x() + 10, half_turn.y() + 5, half_turn.z() - 8),
                           Vec3(5, 6, 7)};
    const Simulated run = match_simulated(model, part, 12000, 3, T);
    EXPECT_LT(rotation_angle(run.error.R), 0.02 * std::numbers::pi / 180) << half_turn.transpose();
    EXPECT_TRUE(run.match->equivalents.empty());
  }
}

TEST(MatchScan, APlateTooThickIsNotTurnedOver) {
  // Turned over it fits as well by its outer planes, and the error in thickness is shared out between two of
  // them: but there neither the slot nor the holes are.
  const auto plate = [](double thickness) {
    const auto hole = [](double x, double y, double r) {
      return "multmatrix([[1, 0, 0, " + std::to_string(x) + "], [0, 1, 0, " + std::to_string(y) +
             "], [0, 0, 1, -1], [0, 0, 0, 1]]) { cylinder($fn = 0, $fa = 12, $fs = 2, h = 40, r1 = " +
             std::to_string(r) + ", r2 = " + std::to_string(r) + ", center = false); }\n";
    };
    return solid("difference() {\n" + block("52, 34, " + std::to_string(thickness), "0 0 0") +
                 hole(12, 10, 4) + hole(38, 24, 3) + block("8, 14, 20", "20 6 4") + "}\n");
  };
  const Solid model = plate(9);
  for (const double thickness : {8.7, 9.3, 9.5}) {
    const Simulated run = match_simulated(model, plate(thickness), 15000, 5);
    EXPECT_LT(rotation_angle(run.error.R), 0.02 * std::numbers::pi / 180) << thickness;
    EXPECT_TRUE(run.match->equivalents.empty()) << thickness;
  }
}

TEST(MatchScan, ABoxWithAHoleIsResolvedByRaysAlone) {
  // A bore has no plane: the six planes of the box leave four poses, and only rays into the bore say which.
  const Solid model = solid(
      "difference() { cube(size = [60, 40, 15], center = false); multmatrix([[1, 0, 0, 15], [0, 1, 0, 12], "
      "[0, 0, 1, "
      "-1], [0, 0, 0, 1]]) { cylinder($fn = 0, $fa = 12, $fs = 2, h = 17, r1 = 6, r2 = 6, center = false); } "
      "}\n");
  const Simulated run = match_simulated(model, 8000, 1);
  EXPECT_TRUE(run.match->equivalents.empty());
  EXPECT_LT(rotation_angle(run.error.R), 0.02 * std::numbers::pi / 180);
  // The three other poses (and those that fit four of the six planes) are ruled out by the bore.
  const auto bore = std::find_if(model.faces().begin(), model.faces().end(),
                                 [](const Face& face) { return face.type == SurfaceType::cylinder; });
  ASSERT_NE(bore, model.faces().end());
  EXPECT_GE(run.match->ruled_out.size(), 3u);
  for (const RuledOutPose& other : run.match->ruled_out)
    EXPECT_TRUE(std::find(other.model_faces.begin(), other.model_faces.end(), bore->id) !=
                other.model_faces.end())
        << other.why;
}

TEST(MatchScan, AFlangeIsHeldByItsRimHoweverManyPointsLieOnItsPlanes) {
  // Two large planes and a rim: the planes leave it free to slide and to turn, its curved faces hold it
  // across its axis, its one bolt hole holds the turn.
  const auto at = [](double x, double y, double z, double h, double r) {
    const auto number = [](double value) { return std::to_string(value); };
    return "multmatrix([[1, 0, 0, " + number(x) + "], [0, 1, 0, " + number(y) + "], [0, 0, 1, " + number(z) +
           "], [0, 0, 0, 1]]) { cylinder($fn = 0, $fa = 12, $fs = 2, h = " + number(h) +
           ", r1 = " + number(r) + ", r2 = " + number(r) + ", center = false); }\n";
  };
  const Solid model = solid("difference() { union() {\n" + at(0, 0, 0, 5, 26) + at(0, 0, 4, 9, 11) + "}\n" +
                            at(0, 0, -1, 30, 6) + at(19, 0, -1, 30, 4) + "}\n");
  const RigidTransform T{rotation_from_degrees(15, 20, 25), Vec3(5, 6, 7)};
  const Simulated run = match_simulated(model, model, 12000, 4, T);
  EXPECT_TRUE(run.match->undetermined.empty());
  EXPECT_TRUE(run.match->equivalents.empty());
  // The pose's own covariance, five standard deviations of each of the six.
  const Vec3 turn = run.error.R * Vec3::UnitX() - Vec3::UnitX(), lean = run.error.R * Vec3::UnitZ();
  EXPECT_LT(std::abs(turn.y()), 5 * std::sqrt(run.match->covariance(2, 2)));
  EXPECT_LT(std::abs(lean.y()), 5 * std::sqrt(run.match->covariance(0, 0)));
  EXPECT_LT(std::abs(lean.x()), 5 * std::sqrt(run.match->covariance(1, 1)));
  const Vec3 shift = run.error * model.centroid_mm - model.centroid_mm;
  for (int k = 0; k < 3; ++k)
    EXPECT_LT(std::abs(shift[k]), 5 * std::sqrt(run.match->covariance(3 + k, 3 + k)));
  // And that is small: thousands of points of sigma 0.02 mm hold it.
  EXPECT_LT(std::sqrt(run.match->covariance.block<3, 3>(3, 3).trace()), 0.01);
}

}  // namespace
}  // namespace tetragauge
