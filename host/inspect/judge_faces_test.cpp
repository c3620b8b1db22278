// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/judge_faces.hpp"

#include <gtest/gtest.h>

namespace tetragauge {
namespace {

TEST(Decide, VerdictTable) {
  struct Case {
    double deviation, U, limit;
    Verdict guarded, iso, simple;
  };
  using enum Verdict;
  // ISO 14253-1:2017's guard band is 0.825 U at k = 2: 0.0165 for U = 0.02.
  const Case cases[] = {
      {0.00, 0.02, 0.05, pass, pass, pass},
      {0.03, 0.02, 0.05, pass, pass, pass},         // just fits
      {0.0301, 0.02, 0.05, undecided, pass, pass},  // in the guard band, with 95 % conformity inside
      {0.0336, 0.02, 0.05, undecided, undecided, pass},
      {0.05, 0.02, 0.05, undecided, undecided, pass},
      {0.0501, 0.02, 0.05, undecided, undecided, fail},
      {0.0666, 0.02, 0.05, undecided, fail, fail},
      {0.0701, 0.02, 0.05, fail, fail, fail},
      {-0.0701, 0.02, 0.05, fail, fail, fail},
      {-0.03, 0.019, 0.05, pass, pass, pass},
      {0.00, 0.06, 0.05, undecided, pass, pass},  // U alone beyond the limit: 0.0495 is not
      {0.00, 0.07, 0.05, undecided, undecided, pass},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(decide(c.deviation, c.U, c.limit, Rule::guarded), c.guarded) << c.deviation << " " << c.U;
    EXPECT_EQ(decide(c.deviation, c.U, c.limit, Rule::iso14253), c.iso) << c.deviation << " " << c.U;
    EXPECT_EQ(decide(c.deviation, c.U, c.limit, Rule::simple), c.simple) << c.deviation << " " << c.U;
  }
}

TEST(Decide, SeverityIsFailUndecidedNotMeasuredPass) {
  using enum Verdict;
  const Verdict order[] = {none, pass, not_measured, undecided, fail};
  for (int a = 0; a < 5; ++a)
    for (int b = 0; b < 5; ++b) EXPECT_EQ(worse(order[a], order[b]), order[std::max(a, b)]);
  EXPECT_EQ(worse(pass, skipped), pass);
}

TEST(Decide, TheWorstCriterionDecides) {
  FaceInspection face;
  face.measured = true;
  face.offset_mm = -0.2;
  face.U_offset_mm = 0.01;
  face.profile_mm = 0.21;
  face.U_profile_mm = 0.01;
  face.form_mm = 0.01;
  face.U_form_mm = 0.002;
  FaceTolerance tolerance;
  tolerance.flatness_mm = 0.02;
  judge_face(face, tolerance, Rule::guarded);
  EXPECT_EQ(face.verdict, Verdict::pass);
  EXPECT_EQ(face.decided_by->name, "flatness");
  tolerance.profile_mm = 0.3;  // +- 0.15
  judge_face(face, tolerance, Rule::guarded);
  EXPECT_EQ(face.verdict, Verdict::fail);
  EXPECT_EQ(face.decided_by->name, "profile");
  EXPECT_DOUBLE_EQ(face.decided_by->deviation, -0.21);
  EXPECT_DOUBLE_EQ(face.decided_by->limit, 0.15);
  judge_face(face, {}, Rule::guarded);
  EXPECT_EQ(face.verdict, Verdict::none);
}

// Two opposed faces and one across, each with the given offset; U of the pose 0.5 along x.
struct Opposed {
  Solid model;
  Tolerances tolerances;
  std::vector<FaceInspection> faces;

  Opposed(double left, double right) {
    tolerances.given = true;
    tolerances.by_default.profile_mm = 0.2;
    const Vec3 normals[] = {-Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitZ()};
    const double offsets[] = {left, right, 0.0};
    for (int k = 0; k < 3; ++k) {
      Face face;
      face.id = k + 1;
      face.normal = normals[k];
      model.list.faces.push_back(face);
      FaceInspection in;
      in.model_id = k + 1;
      in.measured = true;
      in.offset_mm = in.profile_mm = offsets[k];
      in.u_offset_own_mm = 0.002;
      in.U_offset_mm = in.U_profile_mm = k < 2 ? 0.5 : 0.005;
      judge_face(in, tolerances.by_default, Rule::guarded);
      faces.push_back(in);
    }
    judge_distances(model, tolerances, faces, Rule::guarded);
  }
};

TEST(Decide, AWrongDistanceFailsBothCandidates) {
  const Opposed wrong(0.2, 0.2);  // 0.4 mm too far apart, limits 0.1 each
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(wrong.faces[static_cast<size_t>(k)].verdict, Verdict::fail);
    EXPECT_EQ(wrong.faces[static_cast<size_t>(k)].candidate_with, 2 - k);
    EXPECT_DOUBLE_EQ(wrong.faces[static_cast<size_t>(k)].decided_by->deviation, 0.4);
  }
  EXPECT_EQ(wrong.faces[2].verdict, Verdict::pass);
  // Whichever of them is out by 0.06 is within 0.1, wherever the pose has put the two.
  const Opposed right(0.03, 0.03);
  EXPECT_EQ(right.faces[0].verdict, Verdict::pass);
  EXPECT_EQ(right.faces[1].verdict, Verdict::pass);
  EXPECT_DOUBLE_EQ(right.faces[0].decided_by->deviation, 0.06);
  // Not where one is out by more than their distance tells: that is no question of the pose.
  const Opposed apart(0.09, -0.09);
  EXPECT_EQ(apart.faces[0].verdict, Verdict::undecided);
  // 0.15 + 0.04 is within what the two may be off together; shifting the part between them changes nothing.
  for (const double shift : {0.0, 0.3, -0.3}) {
    const Opposed fits(0.15 + shift, 0.04 - shift);
    EXPECT_EQ(fits.faces[0].verdict, Verdict::undecided);
    EXPECT_EQ(fits.faces[1].verdict, Verdict::undecided);
  }
}

}  // namespace
}  // namespace tetragauge
