// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/find_misplaced.hpp"

#include <gtest/gtest.h>

#include "host/match/test_parts.hpp"

namespace tetragauge {
namespace {

using namespace test;
constexpr double kDeg = std::numbers::pi / 180;
constexpr int kBossFirst = 7, kBossTop = 11;  // ids of the first boss: four sides, then the top

// Four sides and the top of a block whose middle below stands at `middle`, turned and moved by `motion`
// there.
std::vector<Face> boss(const Vec3& size, const Vec3& middle, const RigidTransform& motion) {
  const RigidTransform T = RigidTransform{Mat3::Identity(), middle} * motion *
                           RigidTransform{Mat3::Identity(), Vec3(-size.x() / 2, -size.y() / 2, 0)};
  std::vector<Face> faces;
  for (const Face& face : box(size.x(), size.y(), size.z()).faces)
    if (std::abs(face.normal.z()) < 0.1) faces.push_back(moved(face, T));
  for (const Face& face : box(size.x(), size.y(), size.z()).faces)
    if (face.normal.z() > 0.9) faces.push_back(moved(face, T));
  return faces;
}

// A plate 100 x 60 x 20 with two bosses on it; the first is moved by `motion` about its middle.
FaceList plate_with_bosses(const RigidTransform& motion = {}) {
  FaceList list = box(100, 60, 20);
  for (const std::vector<Face>& faces :
       {boss({24, 16, 12}, {40, 30, 20}, motion), boss({20, 10, 8}, {80, 40, 20}, {})})
    list.faces.insert(list.faces.end(), faces.begin(), faces.end());
  number_from_one(list);
  return list;
}

Result<Match> match_boss(const RigidTransform& motion, uint64_t seed) {
  std::mt19937_64 random(seed);
  FaceList measured = moved(plate_with_bosses(motion), random_pose(random).inverse());
  for (Face& face : measured.faces) disturb(face, 1e-5, 0.001, random);
  return match_face_lists(plate_with_bosses(), measured);
}

TEST(FindMisplaced, ABossMovedIsFoundWithItsMotion) {
  uint64_t seed = 1;
  // Within the gate of 1.8 mm, beyond it, far beyond it.
  for (const Vec3& shift : {Vec3(0.5, -0.3, 0), Vec3(3, 2, 0), Vec3(-15, 9, 0)}) {
    const Result<Match> match = match_boss({Mat3::Identity(), shift}, seed++);
    ASSERT_TRUE(match.ok());
    ASSERT_EQ(match->misplaced.size(), 1u) << shift.transpose();
    const MisplacedFeature& feature = match->misplaced[0];
    EXPECT_EQ(feature.pairs.size(), 4u);  // its top is where it should be
    for (const FaceIds& pair : feature.pairs) {
      EXPECT_GE(pair.model, kBossFirst);
      EXPECT_EQ(pair.model, pair.measured);
    }
    EXPECT_LT((feature.shift_mm - shift).norm(), 0.02) << feature.shift_mm.transpose();
    EXPECT_LT(feature.turn_rad, 1e-3);
    // Its pose takes its faces to where they should be.
    const RigidTransform own = feature.T_model_part * match->T_model_part.inverse();
    EXPECT_LT((own * (Vec3(40, 30, 26) + shift) - Vec3(40, 30, 26)).norm(), 0.02);
  }
}

TEST(FindMisplaced, ABossTurnedIsFoundWithItsAngle) {
  uint64_t seed = 10;
  for (const double turn_deg : {2.0, 20.0}) {
    const Result<Match> match = match_boss({rotation_from_degrees(0, 0, turn_deg), Vec3::Zero()}, seed++);
    ASSERT_TRUE(match.ok());
    ASSERT_EQ(match->misplaced.size(), 1u) << turn_deg;
    EXPECT_EQ(match->misplaced[0].pairs.size(), 4u);
    EXPECT_NEAR(match->misplaced[0].turn_rad, turn_deg * kDeg, 0.02 * kDeg);
    EXPECT_LT(match->misplaced[0].shift_mm.norm(), 0.02);
  }
}

TEST(FindMisplaced, ABossRaisedAndTiltedIsAllFive) {
  const Result<Match> match = match_boss({rotation_from_degrees(1, 0.5, 0), Vec3(0, 0, 1)}, 20);
  ASSERT_TRUE(match.ok());
  ASSERT_EQ(match->misplaced.size(), 1u);
  ASSERT_EQ(match->misplaced[0].pairs.size(), 5u);
  EXPECT_EQ(match->misplaced[0].pairs.back().model, kBossTop);
  EXPECT_NEAR(match->misplaced[0].turn_rad, std::hypot(1, 0.5) * kDeg, 0.03 * kDeg);
}

TEST(FindMisplaced, AFaceOrAWidthOutOfPlaceIsNoFeature) {
  EXPECT_TRUE(match_boss({}, 30)->misplaced.empty());
  std::mt19937_64 random(31);
  for (const bool both : {false, true}) {
    FaceList measured = plate_with_bosses();
    for (Face& face : measured.faces) {
      const bool moves = face.id >= kBossFirst && face.id < kBossTop &&
                         (both ? std::abs(face.normal.x()) : face.normal.x()) > 0.9;
      if (moves) face.point_mm += 0.6 * face.normal;
      disturb(face, 1e-5, 0.001, random);
    }
    const Result<Match> match = match_face_lists(plate_with_bosses(), measured);
    ASSERT_TRUE(match.ok());
    EXPECT_TRUE(match->misplaced.empty()) << both;
  }
}

}  // namespace
}  // namespace tetragauge
