// SPDX-License-Identifier: GPL-3.0-or-later
// A preview of a box, where anybody can say which beams meet it.
#include <gtest/gtest.h>

#include "host/session/emulated_session.hpp"
#include "host/session/head_geometry.hpp"
#include "host/session/prepare_machine.hpp"
#include "host/teach/preview.hpp"

namespace tetragauge {
namespace {

TEST(TakePreview, EveryCellIsItsBeam) {
  auto session = start_session({.part = box_file()});  // 40 x 30 x 50 mm on the axis
  ASSERT_TRUE(session) << session.error().message;
  PlannedView view;
  view.slide_mm = 175;
  view.table_deg = 30;
  const auto preview = take_preview(*session->link, view, {.columns = 40, .rows = 36});
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_LE(preview->columns, 40u);
  EXPECT_LE(preview->rows, 36u);
  ASSERT_GT(preview->columns, 20u);

  const auto config = read_head_config(*session->link);
  ASSERT_TRUE(config);
  const HeadGeometry head = head_geometry(config->galvo, config->stage);
  const RigidTransform T = T_machine_part(head, view.table_deg, view.slide_mm).inverse();
  const RasterWindow& w = view.window;
  size_t checked = 0, points = 0;
  for (size_t row = 0; row < preview->rows; ++row) {
    for (size_t column = 0; column < preview->columns; ++column) {
      const PreviewCell& cell = preview->at(column, row);
      points += cell.kind == PreviewCell::Kind::point;
      // The ray through this place of the aim plane against the box, slab by slab.
      const double y = w.y_min_mm + (w.y_max_mm - w.y_min_mm) * static_cast<double>(column) /
                                        static_cast<double>(preview->columns - 1);
      const double up = w.up_max_mm - (w.up_max_mm - w.up_min_mm) * static_cast<double>(row) /
                                          static_cast<double>(preview->rows - 1);
      const Vec3 from = T * ray_of_mirrors(head, 0, 0).origin_mm;
      const Vec3 to = T * (head.aim_mm + y * head.y + up * head.up);
      const Vec3 along = (to - from).normalized();
      const auto meets = [&](double grow_mm) {
        const Vec3 low(-20 - grow_mm, -15 - grow_mm, -grow_mm),
            high(20 + grow_mm, 15 + grow_mm, 50 + grow_mm);
        double enter = 0, leave = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
          const double a = (low[axis] - from[axis]) / along[axis],
                       b = (high[axis] - from[axis]) / along[axis];
          enter = std::max(enter, std::min(a, b));
          leave = std::min(leave, std::max(a, b));
        }
        return std::pair{enter < leave, enter};
      };
      // The beam starts a little elsewhere on the mirror, and the raster is even in the mirrors' angles, so
      // that a beam is up to 1.5 mm from its even place: cells near an edge are left out, and on faces met
      // at up to 65 degrees the range is as much as 1.5 tan 65 = 3.2 mm off.
      const double range_mm = meets(0).second;
      if (meets(-3).first) {
        ++checked;
        ASSERT_EQ(cell.kind, PreviewCell::Kind::point) << column << " " << row;
        EXPECT_NEAR(cell.range_mm, range_mm, 3.2) << column << " " << row;
        EXPECT_GT(cell.intensity, 0);
      } else if (!meets(3).first) {
        ASSERT_NE(cell.kind, PreviewCell::Kind::point) << column << " " << row;
      }
    }
  }
  EXPECT_GT(checked, 50u);
  EXPECT_EQ(points, preview->points) << "no two beams share a cell";
  EXPECT_LT(preview->seen.y_max_mm - preview->seen.y_min_mm, 70);
  EXPECT_GT(preview->seen.y_max_mm - preview->seen.y_min_mm, 45);
}

TEST(TakePreview, StoppedIsAnErrorAndTheNextOneIsFine) {
  auto session = start_session({.part = box_file()});
  ASSERT_TRUE(session) << session.error().message;
  std::atomic<bool> stop{false};
  ScanOptions options;
  options.stop = &stop;
  options.on_progress = [&](const ScanProgress&) { stop = true; };
  PlannedView view;
  view.slide_mm = 175;
  EXPECT_FALSE(take_preview(*session->link, view, {}, options));
  EXPECT_TRUE(take_preview(*session->link, view, {}));
}

TEST(TakePreview, AWindowTheMirrorsDoNotReachIsBadInput) {
  auto session = start_session({.part = box_file()});
  ASSERT_TRUE(session) << session.error().message;
  PlannedView view;
  view.window.y_max_mm = 2000;
  const auto preview = take_preview(*session->link, view, {});
  ASSERT_FALSE(preview);
  EXPECT_EQ(preview.error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace tetragauge
