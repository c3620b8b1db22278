// SPDX-License-Identifier: GPL-3.0-or-later
// The face lists printed in the thesis (shared/data/thesis beside the checkout; its README has the truth).
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <numbers>

#include "host/geometry/face_list_file.hpp"
#include "host/match/match_procrustes.hpp"
#include "host/match/pair_changes.hpp"

namespace tetragauge {
namespace {

constexpr double kCm = 10.0;
const std::filesystem::path kThesis =
    std::filesystem::path(TETRAGAUGE_SOURCE_DIR).parent_path() / "shared/data/thesis";

// README of the lists: measured -> model.
const std::map<int, int> kSteps{{1, 2},  {2, 1},  {3, 13}, {4, 7},  {5, 14}, {6, 5},   {7, 3},
                                {8, 10}, {9, 11}, {10, 9}, {11, 6}, {12, 4}, {13, 12}, {14, 8}};

class ThesisLists : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kThesis / "steps-model.hsp"))
      GTEST_SKIP() << "no " << kThesis << ": the thesis's lists are not part of this repository";
  }
  static FaceList list(const char* name) {
    Result<FaceList> read = read_face_list(kThesis / name, kCm);
    EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
    return read.ok() ? *read : FaceList{};
  }
  static Match match(const FaceList& model, const FaceList& measured) {
    MatchOptions options;
    options.is_unsigned = true;
    const Result<Match> result = match_face_lists(model, measured, options);
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
    return result.ok() ? *result : Match{};
  }
  static void expect_pairs(const Match& match, const std::map<int, int>& truth) {
    EXPECT_EQ(match.pairs.size(), truth.size());
    for (const FacePair& pair : match.pairs) {
      const auto at = truth.find(pair.measured);
      ASSERT_NE(at, truth.end()) << "measured face " << pair.measured << " has no partner";
      EXPECT_EQ(at->second, pair.model) << "measured face " << pair.measured;
    }
  }
  static void expect_near_identity(const RigidTransform& T) {
    EXPECT_LT(rotation_angle(T.R), 0.1 * std::numbers::pi / 180);
    EXPECT_LT(T.t.norm(), 0.01 * kCm);
  }
};

TEST_F(ThesisLists, Staircase) {
  const Match found = match(list("steps-model.hsp"), list("steps-measured.hsp"));
  expect_pairs(found, kSteps);
  expect_near_identity(found.T_model_part);
  EXPECT_TRUE(found.equivalents.empty());
  EXPECT_TRUE(found.undetermined.empty());
}

// p' = Rx(60) Ry(30) Rz(45) p, then 10 cm along z.
RigidTransform thesis_motion() {
  return {rotation_from_degrees(60, 0, 0) * rotation_from_degrees(0, 30, 0) * rotation_from_degrees(0, 0, 45),
          Vec3(0, 0, 10 * kCm)};
}

FaceList moved(FaceList list, const RigidTransform& motion) {
  for (Face& face : list.faces) {
    face.normal = motion.R * face.normal;
    face.d_mm += face.normal.dot(motion.t);
    face.point_mm = face.d_mm * face.normal;
  }
  return list;
}

TEST_F(ThesisLists, StaircaseTurnedAndMoved) {
  const RigidTransform motion = thesis_motion();
  const FaceList model = moved(list("steps-model.hsp"), motion);
  const Match found = match(model, list("steps-measured.hsp"));
  expect_pairs(found, kSteps);
  expect_near_identity(motion.inverse() * found.T_model_part);
}

TEST_F(ThesisLists, StaircaseWithAnExtraFace) {
  const Match found = match(list("steps-model.hsp"), list("steps-measured-extra.hsp"));
  expect_pairs(found, kSteps);
  expect_near_identity(found.T_model_part);
  EXPECT_EQ(found.unmatched_measured, std::vector<int>{15});
  EXPECT_TRUE(found.unmatched_model.empty());
}

TEST_F(ThesisLists, ChannelUpToItsSymmetry) {
  const Match found = match(list("samp-model.hsp"), list("samp-measured.hsp"));
  expect_pairs(found, {{1, 2}, {2, 9}, {3, 1}, {4, 4}, {5, 7}, {6, 3}, {7, 8}, {8, 6}, {9, 5}});
  expect_near_identity(found.T_model_part);
  ASSERT_EQ(found.equivalents.size(), 1u);
  // Half a turn about z through the middle, (5, 3) cm.
  const RigidTransform half{rotation_from_degrees(0, 0, 180), Vec3(10 * kCm, 6 * kCm, 0)};
  const RigidTransform rest = half.inverse() * found.equivalents[0].T_model_part;
  EXPECT_LT(rotation_angle(rest.R), 0.2 * std::numbers::pi / 180);
  EXPECT_LT(rest.t.norm(), 0.02 * kCm);
}

TEST_F(ThesisLists, ChannelWithoutAreasHasFourPoses) {
  FaceList model = list("samp-model.hsp"), measured = list("samp-measured.hsp");
  for (FaceList* faces : {&model, &measured})
    for (Face& face : faces->faces) face.area_mm2 = 0;
  EXPECT_EQ(match(model, measured).equivalents.size(), 3u);
}

// What the thesis's own method recovered (its figures 7.9 and 7.10): all faces, 0.1686 degrees in all, and
// the difference of the plane centres.
class ThesisMethod : public ThesisLists, public testing::WithParamInterface<ProcrustesOptions::Links> {
 protected:
  static ProcrustesMatch procrustes(const FaceList& model, const FaceList& measured) {
    ProcrustesOptions options;
    options.links = GetParam();
    const Result<ProcrustesMatch> result = match_procrustes(model, measured, options);
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
    return result.ok() ? *result : ProcrustesMatch{};
  }
};
using Links = ProcrustesOptions::Links;
INSTANTIATE_TEST_SUITE_P(Links, ThesisMethod, testing::Values(Links::all, Links::modes));

constexpr double kPrintedTurn_deg = 0.168, kTurnTolerance_deg = 0.01;

TEST_P(ThesisMethod, StaircaseAsPrinted) {
  const ProcrustesMatch found = procrustes(list("steps-model.hsp"), list("steps-measured.hsp"));
  expect_pairs(found.match, kSteps);
  EXPECT_NEAR(rotation_angle(found.match.T_model_part.R) * 180 / std::numbers::pi, kPrintedTurn_deg,
              kTurnTolerance_deg);
  const Vec3 printed_cm(-0.0016, -0.0093, 0.0015);
  const Vec3 difference_cm = (found.plane_centre_measured_mm - found.plane_centre_model_mm) / kCm;
  EXPECT_LT((difference_cm - printed_cm).norm(), 0.003) << difference_cm.transpose();
  EXPECT_LT((found.plane_centre_measured_mm / kCm - Vec3(3.7443, 3.0094, 2.7958)).cwiseAbs().maxCoeff(),
            0.02);
}

TEST_P(ThesisMethod, StaircaseTurnedAndMovedAsPrinted) {
  const RigidTransform motion = thesis_motion();
  const ProcrustesMatch found =
      procrustes(moved(list("steps-model.hsp"), motion), list("steps-measured.hsp"));
  expect_pairs(found.match, kSteps);
  const RigidTransform error = motion.inverse() * found.match.T_model_part;
  EXPECT_NEAR(rotation_angle(error.R) * 180 / std::numbers::pi, kPrintedTurn_deg, kTurnTolerance_deg);
}

TEST_P(ThesisMethod, AnglesAreThePrintedOnesWithTheMeasuredListTurned) {
  // It printed Rz(-45.0582) Ry(-29.8770) Rx(-59.8692), which has the error of the first pair on the model's
  // side: the rotation of the measured list onto the model.
  const ProcrustesMatch found =
      procrustes(list("steps-model.hsp"), moved(list("steps-measured.hsp"), thesis_motion()));
  expect_pairs(found.match, kSteps);
  const Vec3 deg = degrees_from_rotation(found.match.T_model_part.R);
  EXPECT_LT((deg - Vec3(-59.8692, -29.8770, -45.0582)).cwiseAbs().maxCoeff(), 0.02) << deg.transpose();
}

}  // namespace
}  // namespace tetragauge
