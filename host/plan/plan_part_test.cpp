// SPDX-License-Identifier: GPL-3.0-or-later
// Plans against what the machine then measures, and against what geometry says by hand.
#include "host/plan/plan_part.hpp"

#include <tbb/global_control.h>

#include <numbers>
#include <random>

#include "host/plan/lay_windows.hpp"
#include "host/plan/place_on_table.hpp"
#include "host/plan/test_parts.hpp"

namespace tetragauge {
namespace {

using std::numbers::pi;

PartPlan plan_of(const test::PlacedPart& part, const PlanPartOptions& options = {}) {
  auto plan = plan_part(nominal_machine(), part.model, part.caster, part.T_part_model, options);
  EXPECT_TRUE(plan) << plan.error().message;
  return plan ? *plan : PartPlan{};
}

TEST(PlanPart, SaysWhatCannotBeSeenAndWhy) {
  const test::PlacedPart part = test::placed(test::kSlotted);
  const PartPlan plan = plan_of(part);
  ASSERT_EQ(plan.faces.size(), part.model.faces().size());
  const auto face = [&](const Vec3& normal, double d) -> const FaceOutlook& {
    return plan.faces[static_cast<size_t>(test::face_at(part.model, normal, d)) - 1];
  };
  const FaceOutlook& bottom = face(-Vec3::UnitZ(), 0);
  EXPECT_FALSE(bottom.is_seen);
  EXPECT_EQ(bottom.obstacle, Obstacle::turned_away);
  EXPECT_NE(bottom.why.find("underside"), std::string::npos) << bottom.why;
  // Slot and hole end in one plane; the hole's bottom of 16 mm2 is the one that nothing reaches: a beam at 59
  // degrees at the steepest comes 4 / tan(31) = 6.7 mm down its walls.
  size_t unseen = 0;
  for (const FaceOutlook& f : plan.faces) {
    if (f.id == bottom.id || f.is_seen) continue;
    ++unseen;
    EXPECT_NEAR(part.model.faces()[static_cast<size_t>(f.id) - 1].area_mm2, 16, 1e-6);
    EXPECT_TRUE(f.obstacle == Obstacle::beam_blocked || f.obstacle == Obstacle::cameras_blocked);
    EXPECT_NE(f.why.find("occluded"), std::string::npos) << f.why;
  }
  EXPECT_EQ(unseen, 1u);
  for (const Vec3& side : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1)}) {
    const FaceOutlook& outer = face(side, side.x() > 0 ? 60 : side.y() > 0 ? 50 : side.z() > 0 ? 40 : 0);
    EXPECT_TRUE(outer.is_seen);
    EXPECT_GT(outer.visible_share, 0.99) << outer.id;
  }
}

// A roof of 80 degrees: its slopes look nearly sideways and are seen; of a wall that leans over by 40 degrees
// the normal points 40 degrees down, and no beam meets it within 65: the flattest comes 35 - 20 degrees from
// above.
TEST(PlanPart, NamesTheIncidenceThatIsTooFlat) {
  const test::PlacedPart part = test::placed(
      "multmatrix([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) { linear_extrude(height = 40, "
      "scale = "
      "[1, 1]) { polygon(points = [[0, 0], [30, 0], [63.5644, 40], [0, 40]], paths = undef); } }\n");
  const PartPlan plan = plan_of(part);
  const Vec3 leaning = Vec3(std::cos(40 * pi / 180), 0, -std::sin(40 * pi / 180));
  const FaceOutlook* face = nullptr;
  for (size_t f = 0; f < plan.faces.size(); ++f)
    if ((part.model.faces()[f].normal - leaning).norm() < 1e-4) face = &plan.faces[f];
  ASSERT_NE(face, nullptr);
  // The least the machine could do: aim and head 350 mm apart, part as high as slide and mirrors let it.
  EXPECT_GT(face->least_incidence_deg, 50);
  if (!face->is_seen) {
    EXPECT_EQ(face->obstacle, Obstacle::none);
    EXPECT_NE(face->why.find("incidence"), std::string::npos) << face->why;
    EXPECT_GT(face->least_incidence_deg, 65);
  }
  // Held to 40 degrees a plain wall is seen from the front, the leaning one is not.
  PlanPartOptions strict;
  strict.max_incidence_deg = 40;
  const PartPlan tight = plan_of(part, strict);
  const FaceOutlook& again = tight.faces[static_cast<size_t>(face->id) - 1];
  EXPECT_FALSE(again.is_seen);
  EXPECT_EQ(again.obstacle, Obstacle::none);
  EXPECT_NEAR(again.least_incidence_deg, face->least_incidence_deg, 1e-9);
}

TEST(PlanPart, EveryVisibleFaceGetsItsPoints) {
  const test::PlacedPart part = test::placed(test::kSlotted);
  auto session = start_session({.part = part.file});
  ASSERT_TRUE(session) << session.error().message;
  PlanPartOptions options;
  options.points_per_face = 150;
  const PartPlan plan = plan_of(part, options);
  const auto measured = run_scan(*session->link, plan.scan);
  ASSERT_TRUE(measured) << measured.error().message;
  EXPECT_NEAR(measured->counts.machine_time_s, plan.time_s, 0.05 * plan.time_s);

  const RigidTransform T_model_part = part.T_part_model.inverse();
  std::vector<size_t> points(plan.faces.size(), 0);
  for (size_t i = 0; i < measured->scan.size(); ++i) {
    const Vec3 origin = T_model_part * measured->scan.ray_origins[i],
               at = T_model_part * measured->scan.points[i];
    const Vec3 direction = (at - origin).normalized();
    const auto hit = part.caster.first_hit(origin, direction);
    if (!hit || std::abs(hit->distance_mm - (at - origin).norm()) > 0.3) continue;
    if (-hit->normal.dot(direction) < std::cos(65 * pi / 180)) continue;
    ++points[static_cast<size_t>(hit->face)];
  }
  for (size_t f = 0; f < plan.faces.size(); ++f) {
    if (!plan.faces[f].is_seen) continue;
    EXPECT_GE(points[f], options.points_per_face) << plan.faces[f].id;
    // No less than what was forecast by the model alone, but for what edges cut.
    EXPECT_GE(static_cast<double>(points[f]), 0.88 * static_cast<double>(plan.faces[f].points) - 10)
        << plan.faces[f].id;
  }
}

TEST(PlanPart, IsTheSameOnAnyNumberOfThreads) {
  const test::PlacedPart part = test::placed(test::kSlotted);
  const std::string one = [&] {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    return plan_json(plan_of(part).scan);
  }();
  EXPECT_EQ(plan_json(plan_of(part).scan), one);
}

TEST(PlanPart, WhatStandsOutsideTheReachIsAnErrorThatSaysSo) {
  test::PlacedPart part = test::placed(test::kSlotted);
  part.T_part_model.t.z() += 1000;
  const auto plan = plan_part(nominal_machine(), part.model, part.caster, part.T_part_model);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().kind, ErrorKind::bad_input);
  EXPECT_NE(plan.error().message.find("no face"), std::string::npos) << plan.error().message;
}

TEST(LayWindows, HoldEverySpotAndTakeNoLongerThanOne) {
  const RasterCost cost = raster_cost(nominal_machine(), 1, 36);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-60, 60);
  for (int n = 1; n <= 40; ++n) {
    std::vector<WindowSpot> spots;
    // Clumps: what cutting is for.
    for (int clump = 0; clump < 1 + n % 4; ++clump) {
      const double y = at(random), up = at(random);
      for (int k = 0; k < n; ++k) spots.push_back({y + 0.1 * at(random), up + 0.1 * at(random), 0.5});
    }
    const WindowLayout layout = lay_windows(spots, cost);
    EXPECT_LE(layout.time_s, time_of_window_s(spots, cost) + 1e-9);
    for (const WindowSpot& spot : spots) {
      EXPECT_TRUE(std::any_of(layout.windows.begin(), layout.windows.end(), [&](const RasterWindow& w) {
        return spot.y_mm - spot.reach_mm >= w.y_min_mm && spot.y_mm + spot.reach_mm <= w.y_max_mm &&
               spot.up_mm - spot.reach_mm >= w.up_min_mm && spot.up_mm + spot.reach_mm <= w.up_max_mm;
      }));
    }
  }
}

// By the emulator's rule, in docs/conventions.md: turned, stood on the table over the axis, then shifted.
TEST(PlaceOnTable, StandsAsTheEmulatedMachineDoes) {
  const test::PlacedPart part = test::placed(test::kSlotted);
  const RigidTransform place{rotation_from_degrees(90, 0, 30), Vec3(3, -4, 0)};
  const Solid standing = transformed(part.model, place_on_table(part.model, place));
  const Vec3 middle = 0.5 * (standing.box_min_mm + standing.box_max_mm);
  EXPECT_NEAR(middle.x(), 3, 1e-9);
  EXPECT_NEAR(middle.y(), -4, 1e-9);
  EXPECT_NEAR(standing.box_min_mm.z(), 0, 1e-9);
}

}  // namespace
}  // namespace tetragauge
