// SPDX-License-Identifier: Apache-2.0
// The world's true geometry and the firmware's are two sets of numbers and formulas; in the nominal world
// they must agree. (Each is checked on its own in its own folder.)
#include <gtest/gtest.h>

#include "firmware/hal/board.hpp"
#include "firmware/machine_config.hpp"
#include "firmware/optics/galvo.hpp"
#include "firmware/optics/psd_camera.hpp"
#include "firmware/optics/stage.hpp"
#include "sim/world.hpp"

namespace tetragauge {
namespace {

Vec3 host_vector(const Vector3<double>& v) {
  return {v.x, v.y, v.z};
}

TEST(GeometryAgrees, Beams) {
  const auto firmware = geometry_of<double>(nominal_config());
  const auto world = sim::nominal_geometry();
  for (double a = -0.15; a <= 0.151; a += 0.05) {
    for (double b = -0.15; b <= 0.151; b += 0.05) {
      const auto believed = beam_from_mirrors(firmware.galvo, a, b);
      const auto real = sim::beam_of_mirrors(world, a, b);
      EXPECT_LT((host_vector(believed.origin) - real.point).norm(), 1e-9);
      EXPECT_LT((host_vector(believed.direction) - real.direction).norm(), 1e-12);
    }
  }
}

TEST(GeometryAgrees, Cameras) {
  const auto firmware = geometry_of<double>(nominal_config());
  const auto world = sim::nominal_geometry();
  for (int c = 0; c < 2; ++c) {
    for (const double x : {-50.0, 0.0, 50.0}) {
      for (const double y : {-50.0, 0.0, 50.0}) {
        for (const double z : {150.0, 200.0, 250.0}) {
          bool in_view = false;
          const auto believed = project(firmware.camera[c], Vector3<double>{x, y, z}, &in_view);
          const auto real = sim::image_on_detector(world.cameras[static_cast<size_t>(c)], {x, y, z});
          ASSERT_TRUE(real);
          const double half_mm = firmware.camera[c].half_size_mm;
          EXPECT_NEAR(believed.x_mm / half_mm, real->x, 1e-12);
          EXPECT_NEAR(believed.y_mm / half_mm, real->y, 1e-12);
        }
      }
    }
  }
}

TEST(GeometryAgrees, StageAndConverters) {
  const MachineConfig config = nominal_config();
  const auto firmware = geometry_of<double>(config);
  const sim::WorldSetup world;
  const Vector3<double> part{10, -20, 30};
  for (const double table_rad : {0.0, 0.7, 3.0}) {
    const Vec3 believed = host_vector(machine_from_part(firmware.stage, table_rad, 40.0, part));
    const Vec3 real = sim::table_pose(world.geometry, table_rad, 40) * host_vector(part);
    EXPECT_LT((believed - real).norm(), 1e-9);
  }
  EXPECT_EQ(world.numbers.table_steps_per_turn, static_cast<int32_t>(config.stage.table_steps_per_turn));
  EXPECT_DOUBLE_EQ(world.numbers.slide_mm_per_step, 1000.0 / config.stage.slide_steps_per_m);
  EXPECT_EQ(world.numbers.table_home_steps, config.stage.table.home_steps);
  EXPECT_EQ(world.numbers.slide_home_steps, config.stage.slide.home_steps);
  EXPECT_LT(world.numbers.slide_limit_low_steps, config.stage.slide.home_steps);
  EXPECT_GT(world.numbers.slide_limit_high_steps, config.stage.slide.max_steps);
  EXPECT_DOUBLE_EQ(world.numbers.rad_per_mirror_code, kUradPerMirrorCode * 1e-6);
}

}  // namespace
}  // namespace tetragauge
