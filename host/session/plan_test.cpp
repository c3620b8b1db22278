// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/plan.hpp"

#include <gtest/gtest.h>

#include "firmware/optics/nominal_geometry.hpp"
#include "host/session/emulated_session.hpp"
#include "host/session/head_geometry.hpp"

namespace tetragauge {
namespace {

Result<ScanPlan> plan_of(const std::string& text) {
  return read_plan(temporary_file("plan.json", text));
}

TEST(Plan, ViewsTakeWhatTheyDoNotSayFromThePlan) {
  const auto plan = plan_of(R"({"pitch_mm": 2, "samples": 20, "window_mm": {"y": [-30, 30]},
      "views": [{"table_deg": 0, "slide_mm": 150}, {"table_deg": 45, "slide_mm": 100, "pitch_mm": 0.5, "window_mm": {"up": [0, 10]}}]})");
  ASSERT_TRUE(plan) << plan.error().message;
  ASSERT_EQ(plan->views.size(), 2u);
  EXPECT_EQ(plan->views[0].pitch_mm, 2);
  EXPECT_EQ(plan->views[0].samples, 20u);
  EXPECT_EQ(plan->views[0].window.y_min_mm, -30);
  EXPECT_EQ(plan->views[1].table_deg, 45);
  EXPECT_EQ(plan->views[1].pitch_mm, 0.5);
  EXPECT_EQ(plan->views[1].window.y_max_mm, 30);
  EXPECT_EQ(plan->views[1].window.up_min_mm, 0);
}

TEST(Plan, ErrorsNameThePlaceAndTheRemedy) {
  const struct {
    const char* text;
    std::initializer_list<const char*> words;
  } kCases[] = {
      {"{", {"plan.json", "JSON"}},
      {"[]", {"object"}},
      {"{}", {"views"}},
      {R"({"views": []})", {"views"}},
      {R"({"pitch": 1, "views": [{"table_deg": 0, "slide_mm": 0}]})", {"\"pitch\"", "\"pitch_mm\""}},
      {R"({"views": [{"table_deg": 0, "slide_mm": 340}]})", {"views[0].slide_mm = 340", "300 mm"}},
      {R"({"views": [{"table_deg": 0, "slide_mm": 0}, {"table_deg": 361, "slide_mm": 0}]})",
       {"views[1].table_deg"}},
      {R"({"views": [{"table_deg": 0}]})", {"views[0]", "slide_mm"}},
      {R"({"views": [{"tabel_deg": 0, "slide_mm": 0}]})", {"tabel_deg", "table_deg"}},
      {R"({"samples": 7, "views": [{"table_deg": 0, "slide_mm": 0}]})", {"samples = 7", "even"}},
      {R"({"pitch_mm": 0, "views": [{"table_deg": 0, "slide_mm": 0}]})", {"pitch_mm = 0"}},
      {R"({"window_mm": {"y": [5, -5]}, "views": [{"table_deg": 0, "slide_mm": 0}]})",
       {"window_mm.y", "swap"}},
      {R"({"window_mm": {"x": [0, 5]}, "views": [{"table_deg": 0, "slide_mm": 0}]})", {"window_mm", "\"x\""}},
  };
  for (const auto& c : kCases) {
    const auto plan = plan_of(c.text);
    ASSERT_FALSE(plan) << c.text;
    EXPECT_EQ(plan.error().kind, ErrorKind::bad_input);
    for (const char* word : c.words)
      EXPECT_NE(plan.error().message.find(word), std::string::npos) << plan.error().message;
  }
  EXPECT_EQ(read_plan("/nonexistent/plan.json").error().kind, ErrorKind::bad_input);
}

tg_Vector message(const Vector3<double>& v) {
  return {v.x, v.y, v.z};
}

HeadGeometry nominal_head() {
  const auto machine = nominal_geometry<double>();
  tg_GalvoConfig galvo = tg_GalvoConfig_init_zero;
  galvo.beam_point_mm = message(machine.galvo.beam_point);
  galvo.beam_direction = message(machine.galvo.beam_direction);
  galvo.a_point_mm = message(machine.galvo.a_point);
  galvo.a_axis = message(machine.galvo.a_axis);
  galvo.a_normal = message(machine.galvo.a_normal);
  galvo.b_point_mm = message(machine.galvo.b_point);
  galvo.b_axis = message(machine.galvo.b_axis);
  galvo.b_normal = message(machine.galvo.b_normal);
  galvo.a_scale = galvo.b_scale = 1;
  galvo.limit_urad = 174'533;
  tg_StageConfig stage = tg_StageConfig_init_zero;
  stage.axis_direction = stage.slide_direction = {0, 0, 1};
  return head_geometry(galvo, stage);
}

TEST(HeadGeometry, AimsAtTheAxisAndLooks35DegreesDown) {
  const HeadGeometry head = nominal_head();
  EXPECT_LT((head.aim_mm - Vec3(0, 0, 200)).norm(), 1e-9);
  EXPECT_LT((head.y - Vec3::UnitY()).norm(), 1e-9);
  const double degree = std::acos(-1.0) / 180;
  EXPECT_LT((head.up - Vec3(-std::sin(35 * degree), 0, std::cos(35 * degree))).norm(), 1e-9);
}

TEST(LayRaster, BeamsMeetTheAimPlaneWhereTheWindowSays) {
  const HeadGeometry head = nominal_head();
  PlannedView planned;
  planned.window = {.y_min_mm = -40, .y_max_mm = 50, .up_min_mm = -30, .up_max_mm = 20};
  planned.pitch_mm = 1;
  const auto view = lay_raster(head, planned);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->columns, 91u);
  EXPECT_EQ(view->rows, 51u);
  const Vec3 toward = head.y.cross(head.up);
  const auto meets = [&](uint32_t column, uint32_t row) {
    const MachineRay ray =
        ray_of_mirrors(head, view->a_first_urad + static_cast<int32_t>(column) * view->a_step_urad,
                       view->b_first_urad + static_cast<int32_t>(row) * view->b_step_urad);
    const double range = toward.dot(head.aim_mm - ray.origin_mm) / toward.dot(ray.direction);
    const Vec3 at = ray.origin_mm + range * ray.direction - head.aim_mm;
    return std::pair(at.dot(head.y), at.dot(head.up));
  };
  // A mirror's tangent bends the raster by less than this over the window.
  constexpr double kBend_mm = 1.0;
  EXPECT_NEAR(meets(0, 0).first, -40, kBend_mm);
  EXPECT_NEAR(meets(0, 0).second, -30, kBend_mm);
  EXPECT_NEAR(meets(90, 50).first, 50, kBend_mm);
  EXPECT_NEAR(meets(90, 50).second, 20, kBend_mm);
  planned.window.y_max_mm = 300;
  EXPECT_FALSE(lay_raster(head, planned));
}

}  // namespace
}  // namespace tetragauge
