// SPDX-License-Identifier: GPL-3.0-or-later
// Judged by what variances do: with n times the points they are an n-th.
#include "host/measure/points_to_decide.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/plan/test_parts.hpp"

namespace tetragauge {
namespace {

// A block whose faces 1 and 2 are measured; face 1 is undecided.
struct Case {
  Solid model = block();
  Tolerances tolerances;
  Inspection inspection;

  static Solid block() {
    return *read_solid(temporary_file("block.csg", "cube(size = [40, 40, 40], center = false);\n"));
  }
  Case() {
    tolerances.given = true;
    for (const Face& face : model.faces()) {
      FaceInspection& found = inspection.faces.emplace_back();
      found.model_id = face.id;
      found.measured = true;
      found.verdict = Verdict::pass;
    }
    tolerances.datums = {{"A", 2, model.faces()[1].normal}};
  }
  void set_tilt_variance(int id, double variance) {
    PlaneAsMeasured plane;
    plane.covariance.matrix = variance * Mat3::Identity();
    inspection.faces[static_cast<size_t>(id) - 1].plane = plane;
  }
  void undecide(const Criterion& criterion) {
    inspection.faces[0].decided_by = criterion;
    inspection.faces[0].verdict = Verdict::undecided;
  }
  std::map<int, double> ask(double u_cal_mm = 0) const {
    return points_to_decide(inspection, model, tolerances, u_cal_mm);
  }
};

TEST(PointsToDecide, AnAngleNeedsMoreOfBothFaces) {
  Case it;
  it.set_tilt_variance(1, 0.3);
  it.set_tilt_variance(2, 0.1);
  // U squared is 4 (0.3 + 0.1); to be a quarter of the limit away from it.
  it.undecide({"angularity", 0.6, 2 * std::sqrt(0.4), 1.2, Verdict::undecided, "A"});
  const auto times = it.ask(0.5);
  ASSERT_EQ(times.size(), 2u);
  EXPECT_DOUBLE_EQ(times.at(1), times.at(2));
  EXPECT_NEAR(2 * std::sqrt((0.3 + 0.1) / times.at(1)), 0.6, 1e-9);
}

TEST(PointsToDecide, OnlyTheFaceThatUComesFrom) {
  Case it;
  it.set_tilt_variance(1, 1);
  it.set_tilt_variance(2, 0.01);
  it.undecide({"perpendicularity", 0.01, 0.05, 0.03, Verdict::undecided, "A"});
  EXPECT_EQ(it.ask().size(), 1u);
  EXPECT_TRUE(it.ask().contains(1));
  it.set_tilt_variance(1, 0.0001);
  EXPECT_EQ(it.ask().size(), 1u);
  EXPECT_TRUE(it.ask().contains(2));
}

TEST(PointsToDecide, NoPointsHelpAgainstTheMachinesOwnShare) {
  Case it;
  it.inspection.faces[0].U_offset_mm = 0.1;
  it.inspection.faces[0].u_offset_own_mm = 0.05;
  it.undecide({"offset", 0.1, 0.1, 0.12, Verdict::undecided, ""});
  EXPECT_TRUE(it.ask(0.049).empty());
  EXPECT_TRUE(it.ask(0.001).contains(1));
}

TEST(PointsToDecide, NothingIsAskedForWhatUIsNotToBlameFor) {
  Case it;
  it.set_tilt_variance(1, 1);
  it.set_tilt_variance(2, 1);
  // Undecided though far from its limit: the pose is not known.
  it.undecide({"profile", 0.01, 0.01, 1, Verdict::undecided, ""});
  EXPECT_TRUE(it.ask().empty());
  // Undecided because another criterion's datum was not measured; this one passes.
  it.undecide({"flatness", 0.01, 0.005, 0.02, Verdict::pass, ""});
  EXPECT_TRUE(it.ask().empty());
}

}  // namespace
}  // namespace tetragauge
