// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "host/match/match.hpp"
#include "host/match/test_parts.hpp"

namespace tetragauge {
namespace {

using namespace test;
constexpr double kDeg = std::numbers::pi / 180;

Vec3 part_centre(const FaceList& model) {
  Vec3 sum = Vec3::Zero();
  for (const Face& face : model.faces) sum += face.point_mm;
  return sum / static_cast<double>(model.faces.size());
}

// Whether `found` is `truth` within the limits, not counting what `free` says is undetermined.
bool holds(const RigidTransform& found, const RigidTransform& truth, const std::vector<FreeDirection>& free,
           const Vec3& centre_model, double angle, double shift) {
  Mat3 turn = found.R * truth.R.transpose();
  Vec3 move = found * (truth.inverse() * centre_model) - centre_model;
  for (const FreeDirection& direction : free) {
    if (direction.kind == FreeDirection::Kind::translation) {
      move -= direction.axis * direction.axis.dot(move);
    } else {  // only where the axis goes matters
      turn = Eigen::Quaterniond::FromTwoVectors(turn * direction.axis, direction.axis).toRotationMatrix();
    }
  }
  return rotation_angle(turn) < angle && move.norm() < shift;
}

bool any_holds(const Match& match, const RigidTransform& truth, const Vec3& centre, double angle,
               double shift) {
  if (holds(match.T_model_part, truth, match.undetermined, centre, angle, shift)) return true;
  return std::any_of(match.equivalents.begin(), match.equivalents.end(), [&](const EquivalentPose& other) {
    return holds(other.T_model_part, truth, match.undetermined, centre, angle, shift);
  });
}

// Planes through the part's box, as another object or a false face would give.
Face extra_face(const FaceList& model, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0, 1);
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (const Face& face : model.faces) {
    low = low.cwiseMin(face.point_mm);
    high = high.cwiseMax(face.point_mm);
  }
  Face face;
  face.normal = Vec3(normal(random), normal(random), normal(random)).normalized();
  for (int k = 0; k < 3; ++k) face.point_mm[k] = low[k] + (high[k] - low[k]) * share(random);
  face.d_mm = face.normal.dot(face.point_mm);
  face.area_mm2 =
      model.faces[static_cast<size_t>(share(random) * static_cast<double>(model.faces.size()))].area_mm2;
  return face;
}

struct Trial {
  FaceList measured;
  std::vector<int> truth;  // model id of each measured face, 0: extra
  RigidTransform T_model_part;
};

Trial trial(const FaceList& model, double missing, double extra, double angle, double offset, bool flip,
            std::mt19937_64& random) {
  Trial out;
  out.T_model_part = random_pose(random);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Face> faces = model.faces;
  std::shuffle(faces.begin(), faces.end(), random);
  faces.resize(static_cast<size_t>(std::ceil(static_cast<double>(faces.size()) * (1 - missing))));
  for (const Face& face : faces) out.truth.push_back(face.id);
  const size_t extras = static_cast<size_t>(static_cast<double>(model.faces.size()) * extra);
  for (size_t k = 0; k < extras; ++k) {
    faces.push_back(extra_face(model, random));
    out.truth.push_back(0);
  }
  for (Face& face : faces) {
    face = moved(face, out.T_model_part.inverse());
    disturb(face, angle, offset, random);
    face.area_mm2 *= 0.8 + 0.4 * share(random);
    if (flip && share(random) < 0.5) {
      face.normal = -face.normal;
      face.d_mm = -face.d_mm;
    }
  }
  out.measured.faces = faces;
  number_from_one(out.measured);
  return out;
}

void staircase_trials(bool is_unsigned, uint64_t seed) {
  const FaceList model = staircase();
  const Vec3 centre = part_centre(model);
  std::mt19937_64 random(seed);
  int wrong_pairs = 0, pairs = 0, with_equivalents = 0;
  for (int n = 0; n < 200; ++n) {
    const Trial t = trial(model, 0.3, 0.3, 0.3 * kDeg, 0.1, is_unsigned, random);
    MatchOptions options;
    options.is_unsigned = is_unsigned;
    const Result<Match> match = match_face_lists(model, t.measured, options);
    ASSERT_TRUE(match.ok()) << n << ": " << match.error().message;
    EXPECT_TRUE(any_holds(*match, t.T_model_part, centre, 1 * kDeg, 1.0)) << "trial " << n;
    const bool slope_seen = std::count(t.truth.begin(), t.truth.end(), 11) > 0;
    with_equivalents += slope_seen && !match->equivalents.empty();
    if (!holds(match->T_model_part, t.T_model_part, match->undetermined, centre, 1 * kDeg, 1.0)) continue;
    for (const FacePair& pair : match->pairs) {
      ++pairs;
      wrong_pairs += t.truth[static_cast<size_t>(pair.measured) - 1] != pair.model;
    }
  }
  // A random plane falls within 3.5 degrees and 1.8 mm of one of the staircase's 14 in about one case of 150;
  // 4 extra faces a trial make some 5 wrong pairs of 2,000.
  EXPECT_LT(wrong_pairs, 20) << "of " << pairs;
  // The slope is the only face without a partner under the half turns that map the staircase's other planes
  // onto each other when normals have no side. Where it is seen, only an extra face in its image's place
  // could make a second pose (1 in 150 for each of 4 extra faces).
  EXPECT_LT(with_equivalents, 10);
}

TEST(MatchFaceLists, StaircaseInRandomPosesWithMissingAndExtraFaces) {
  staircase_trials(false, 1);
}

TEST(MatchFaceLists, StaircaseWithUnsignedNormals) {
  staircase_trials(true, 2);
}

// Brute force over the 24 rotations of a cube's axes: those that map the list onto itself about its centre.
std::vector<RigidTransform> symmetries_by_brute_force(const FaceList& model, bool areas_only) {
  std::vector<RigidTransform> found;
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (const Face& face : model.faces) {
    low = low.cwiseMin(face.point_mm);
    high = high.cwiseMax(face.point_mm);
  }
  const Vec3 centre = 0.5 * (low + high);
  std::array<int, 3> axes{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat3 R = Mat3::Zero();
      for (int k = 0; k < 3; ++k) R(k, axes[static_cast<size_t>(k)]) = (signs >> k) & 1 ? -1 : 1;
      if (R.determinant() < 0) continue;
      const RigidTransform T{R, centre - R * centre};
      const bool same = std::all_of(model.faces.begin(), model.faces.end(), [&](const Face& face) {
        const Face image = moved(face, T);
        return std::any_of(model.faces.begin(), model.faces.end(), [&](const Face& other) {
          return (other.normal - image.normal).norm() < 1e-9 &&
                 (other.point_mm - image.point_mm).norm() < 1e-9 &&
                 (!areas_only || std::abs(other.area_mm2 - image.area_mm2) < 1e-9);
        });
      });
      if (same) found.push_back(T);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  return found;
}

TEST(MatchFaceLists, SymmetricPartsGiveEveryEquivalentPose) {
  struct Case {
    const char* name;
    FaceList model;
    size_t expected;
  };
  const std::vector<Case> cases{{"cube", box(50, 50, 50), 24},
                                {"box with a square base", box(50, 50, 80), 8},
                                {"box", box(30, 50, 80), 4},
                                {"channel", channel(), 2},
                                {"staircase", staircase(), 1}};
  std::mt19937_64 random(3);
  for (const Case& c : cases) {
    const std::vector<RigidTransform> symmetries = symmetries_by_brute_force(c.model, true);
    ASSERT_EQ(symmetries.size(), c.expected) << c.name;
    for (int n = 0; n < 5; ++n) {
      const Trial t = trial(c.model, 0, 0, 0.05 * kDeg, 0.01, false, random);
      const Result<Match> match = match_face_lists(c.model, t.measured);
      ASSERT_TRUE(match.ok()) << c.name;
      EXPECT_EQ(match->equivalents.size() + 1, symmetries.size()) << c.name;
      for (const RigidTransform& S : symmetries)
        EXPECT_TRUE(any_holds(*match, S * t.T_model_part, part_centre(c.model), 0.5 * kDeg, 0.2)) << c.name;
      EXPECT_TRUE(match->undetermined.empty()) << c.name;
    }
  }
}

class RegularPrism : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sides, RegularPrism, testing::Values(6, 35));

TEST_P(RegularPrism, HasTwicePosesAsManyAsSides) {
  const int sides = GetParam();
  const FaceList model = polygon_prism(sides, 119.6, 100);
  std::mt19937_64 random(4);
  const Trial t = trial(model, 0, 0, 0.02 * kDeg, 0.01, false, random);
  const Result<Match> match = match_face_lists(model, t.measured);
  ASSERT_TRUE(match.ok());
  EXPECT_EQ(match->pairs.size(), static_cast<size_t>(sides) + 2);
  EXPECT_EQ(match->equivalents.size() + 1, 2 * static_cast<size_t>(sides));
  for (int flip = 0; flip < 2; ++flip) {
    for (int k = 0; k < sides; ++k) {
      RigidTransform S{rotation_from_degrees(0, -360.0 / sides * k, 0), Vec3::Zero()};
      if (flip) S = S * RigidTransform{rotation_from_degrees(180, 0, 0), Vec3(0, 100, 0)};
      EXPECT_TRUE(any_holds(*match, S * t.T_model_part, part_centre(model), 0.2 * kDeg, 0.2)) << k << flip;
    }
  }
}

TEST(MatchFaceLists, NearSymmetricBoxIsResolvedByOneStep) {
  // A box 100 x 60 x 40 with a step 1.5 mm deep and 10 mm wide along one edge.
  const FaceList model = prism({{0, 0}, {100, 0}, {100, 38.5}, {90, 38.5}, {90, 40}, {0, 40}}, 60);
  std::mt19937_64 random(5);
  for (int n = 0; n < 20; ++n) {
    const Trial t = trial(model, 0, 0, 0.05 * kDeg, 0.02, false, random);
    const Result<Match> match = match_face_lists(model, t.measured);
    ASSERT_TRUE(match.ok());
    EXPECT_TRUE(holds(match->T_model_part, t.T_model_part, {}, part_centre(model), 0.3 * kDeg, 0.3)) << n;
    EXPECT_TRUE(match->equivalents.empty()) << n;
    // The three half turns fit all but the step's faces 3 (its tread) and 4 (its riser).
    EXPECT_GE(match->ruled_out.size(), 1u) << n;
    for (const RuledOutPose& other : match->ruled_out) {
      EXPECT_NEAR(rotation_angle(other.T_model_part.R * match->T_model_part.R.transpose()), 180 * kDeg,
                  1 * kDeg);
      EXPECT_TRUE(std::any_of(other.model_faces.begin(), other.model_faces.end(), [](int id) {
        return id == 3 || id == 4;
      })) << other.why;
    }
  }
}

TEST(MatchFaceLists, OneFaceOutOfPlaceDoesNotPullThePose) {
  const FaceList model = staircase();
  std::mt19937_64 random(6);
  for (const int out : {1, 2, 3, 5, 9, 12}) {  // not the ends: two faces alone along y cannot say which moved
    Trial t = trial(model, 0, 0, 2e-5, 0.002, false, random);
    for (size_t k = 0; k < t.truth.size(); ++k) {
      Face& face = t.measured.faces[k];
      if (t.truth[k] == out) {
        face.point_mm += 0.4 * face.normal;
        face.d_mm += 0.4;
      }
    }
    const Result<Match> match = match_face_lists(model, t.measured);
    ASSERT_TRUE(match.ok());
    EXPECT_TRUE(holds(match->T_model_part, t.T_model_part, {}, part_centre(model), 0.01 * kDeg, 0.01)) << out;
    ASSERT_EQ(match->pairs.size(), 15u);
    for (const FacePair& pair : match->pairs) {
      EXPECT_NEAR(pair.offset_mm, pair.model == out ? 0.4 : 0.0, 0.015) << out << " " << pair.model;
      EXPECT_EQ(pair.used_in_pose, pair.model != out) << out << " " << pair.model;
    }
  }
}

TEST(MatchFaceLists, TwoOpposingFacesAtAWrongDistanceShareIt) {
  const FaceList model = staircase();
  std::mt19937_64 random(7);
  Trial t = trial(model, 0, 0, 2e-5, 0.002, false, random);
  for (size_t k = 0; k < t.truth.size(); ++k)
    if (t.truth[k] == 15) t.measured.faces[k].point_mm += 0.4 * t.measured.faces[k].normal;
  const Result<Match> match = match_face_lists(model, t.measured);
  ASSERT_TRUE(match.ok());
  double sum = 0;
  for (const FacePair& pair : match->pairs) {
    if (pair.model >= 14) {
      sum += pair.offset_mm;
      EXPECT_GT(pair.offset_mm, -0.02);
    } else {
      EXPECT_NEAR(pair.offset_mm, 0.0, 0.015) << pair.model;
    }
  }
  EXPECT_NEAR(sum, 0.4, 0.015);
  // Where the part lies along y is as uncertain as that.
  EXPECT_GT(std::sqrt(match->covariance(4, 4)), 0.05);
  EXPECT_LT(std::sqrt(match->covariance(3, 3)), 0.01);
}

TEST(MatchFaceLists, CovarianceHoldsTheTruth) {
  // Faces with a known covariance, noise drawn from it: the squared Mahalanobis distance of the pose's error
  // is chi-square with 6 degrees of freedom, whose 95 % lie below 12.59.
  const FaceList model = staircase();
  Vec3 pivot = Vec3::Zero();
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  constexpr int kTrials = 1000;
  int inside = 0;
  double mean = 0;
  for (int n = 0; n < kTrials; ++n) {
    const RigidTransform T = random_pose(random);
    FaceList measured = moved(model, T.inverse());
    for (Face& face : measured.faces) {
      PlaneCovariance covariance;
      std::tie(covariance.u, covariance.v) = tangent_frame(face.normal);
      const double side = std::sqrt(face.area_mm2), offset = 0.02 / side, tilt = 0.07 / face.area_mm2;
      covariance.matrix = Vec3(offset * offset, tilt * tilt, tilt * tilt).asDiagonal();
      face.covariance = covariance;
      const double turn_u = tilt * normal(random), turn_v = tilt * normal(random);
      face.point_mm += offset * normal(random) * face.normal;
      // A turn about u takes the normal towards -v, one about v towards +u.
      face.normal = (face.normal - turn_u * covariance.v + turn_v * covariance.u).normalized();
      face.d_mm = face.normal.dot(face.point_mm);
    }
    const Result<Match> match = match_face_lists(model, measured);
    ASSERT_TRUE(match.ok());
    pivot = match->centroid_mm;
    const RigidTransform error = match->T_model_part * T.inverse();  // of the model, about its centroid
    const Eigen::AngleAxisd turn(error.R);
    Vec6 e;
    e << turn.angle() * turn.axis(), error * pivot - pivot;
    const double distance = e.dot(match->covariance.ldlt().solve(e));
    inside += distance < 12.592;
    mean += distance / kTrials;
  }
  EXPECT_GE(inside, 0.92 * kTrials);
  EXPECT_LE(inside, 0.98 * kTrials);
  EXPECT_NEAR(mean, 6.0, 0.6);
}

TEST(MatchFaceLists, NamesWhatNothingDetermines) {
  const FaceList model = staircase();
  std::mt19937_64 random(9);
  FaceList without_ends, top_and_bottom;
  for (const Face& face : model.faces)
    if (face.id < 14) without_ends.faces.push_back(face);
  const RigidTransform T = random_pose(random);
  without_ends = moved(without_ends, T.inverse());
  const Result<Match> match = match_face_lists(model, without_ends);
  ASSERT_TRUE(match.ok());
  ASSERT_EQ(match->undetermined.size(), 1u);
  EXPECT_EQ(match->undetermined[0].kind, FreeDirection::Kind::translation);
  EXPECT_NEAR(std::abs(match->undetermined[0].axis.y()), 1.0, 1e-9);

  for (const Face& face : model.faces)
    if (std::abs(face.normal.z()) > 0.99) top_and_bottom.faces.push_back(face);
  const Result<Match> flat = match_face_lists(model, moved(top_and_bottom, T.inverse()));
  ASSERT_TRUE(flat.ok());
  ASSERT_EQ(flat->undetermined.size(), 3u);
  int rotations = 0;
  for (const FreeDirection& free : flat->undetermined) {
    if (free.kind == FreeDirection::Kind::rotation) {
      ++rotations;
      EXPECT_NEAR(free.axis.z(), 1.0, 1e-9);
    } else {
      EXPECT_NEAR(free.axis.z(), 0.0, 1e-9);
    }
  }
  EXPECT_EQ(rotations, 1);
  EXPECT_EQ(flat->pairs.size(), top_and_bottom.faces.size());
}

TEST(MatchFaceLists, PatchesOfOnePlaneFindTheirOwn) {
  const FaceList model = staircase();  // x = 0 holds faces 10 (z 40..60) and 13 (z 0..10)
  std::mt19937_64 random(10);
  const Trial t = trial(model, 0, 0, 1e-5, 0.001, false, random);
  const Result<Match> match = match_face_lists(model, t.measured);
  ASSERT_TRUE(match.ok());
  for (const FacePair& pair : match->pairs)
    EXPECT_EQ(t.truth[static_cast<size_t>(pair.measured) - 1], pair.model);
}

TEST(MatchFaceLists, OrderOfFacesAndMotionOfThePartDoNotMatter) {
  const FaceList model = staircase();
  std::mt19937_64 random(11);
  Trial t = trial(model, 0.2, 0.2, 0.2 * kDeg, 0.05, false, random);
  const Result<Match> first = match_face_lists(model, t.measured);
  FaceList shuffled = t.measured;
  std::shuffle(shuffled.faces.begin(), shuffled.faces.end(), random);
  const RigidTransform motion = random_pose(random);
  const Result<Match> second = match_face_lists(model, moved(shuffled, motion));
  ASSERT_TRUE(first.ok() && second.ok());
  ASSERT_EQ(first->pairs.size(), second->pairs.size());
  for (size_t k = 0; k < first->pairs.size(); ++k) {
    EXPECT_EQ(first->pairs[k].measured, second->pairs[k].measured);
    EXPECT_NEAR(first->pairs[k].offset_mm, second->pairs[k].offset_mm, 1e-6);
  }
  EXPECT_TRUE(holds(second->T_model_part * motion, first->T_model_part, {}, part_centre(model), 1e-7, 1e-5));
}

TEST(MatchFaceLists, NothingToMatchIsAnError) {
  const FaceList model = staircase();
  const Result<Match> none = match_face_lists(model, FaceList{});
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().kind, ErrorKind::undecided);
  FaceList cylinder;
  cylinder.faces.emplace_back();
  cylinder.faces[0].id = 1;
  cylinder.faces[0].type = SurfaceType::cylinder;
  EXPECT_FALSE(match_face_lists(cylinder, model).ok());
  // A part in another unit: every face is far too large for the model.
  FaceList large = staircase();
  for (Face& face : large.faces) {
    face.point_mm *= 10;
    face.d_mm *= 10;
    face.area_mm2 *= 100;
  }
  const Result<Match> other = match_face_lists(model, large);
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().message.find("unit"), std::string::npos);
}

}  // namespace
}  // namespace tetragauge
