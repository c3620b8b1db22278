// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/world.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/solid/solid.hpp"
#include "sim/read_world.hpp"

namespace tetragauge::sim {
namespace {

// A file that is there while the object is.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& ending, const std::string& text)
      : path_(std::filesystem::temp_directory_path() /
              ("tetragauge-sim-" + std::to_string(::getpid()) + ending)) {
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

Solid box(double x, double y, double z) {
  const TemporaryFile file(".csg", "cube(size = [" + std::to_string(x) + ", " + std::to_string(y) + ", " +
                                       std::to_string(z) + "], center = false);\n");
  const auto solid = read_solid(file.path());
  EXPECT_TRUE(solid) << solid.error().message;
  return *solid;
}

Solid standing_box(double x, double y, double z) {
  return *stand_on_table(box(x, y, z), {}, "box");
}

constexpr int64_t kMs = 1'000'000;

bool equal(const World::Sample& a, const World::Sample& b) {
  for (size_t c = 0; c < 2; ++c) {
    if (a[c].x1 != b[c].x1 || a[c].x2 != b[c].x2 || a[c].y1 != b[c].y1 || a[c].y2 != b[c].y2) return false;
  }
  return true;
}

int sum_of(const DetectorCodes& codes) {
  return codes.x1 + codes.x2;
}

TEST(StandOnTable, TurnsThenStandsThenShifts) {
  const auto turned =
      stand_on_table(box(80, 60, 20), {rotation_from_degrees(90, 0, 0), Vec3(1, 2, 3)}, "box");
  ASSERT_TRUE(turned);
  EXPECT_LT((turned->box_min_mm - Vec3(-39, -8, 3)).norm(), 1e-9);
  EXPECT_LT((turned->box_max_mm - Vec3(41, 12, 63)).norm(), 1e-9);
}

TEST(StandOnTable, RefusesWhatReachesOutOfTheVolume) {
  EXPECT_TRUE(stand_on_table(box(100, 100, 200), {}, "box"));
  for (const auto& [x, y, z] : {std::tuple(101, 10, 10), std::tuple(10, 101, 10), std::tuple(10, 10, 201)}) {
    const auto refused = stand_on_table(box(x, y, z), {}, "huge.csg");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::bad_input);
    EXPECT_NE(refused.error().message.find("huge.csg"), std::string::npos);
  }
  EXPECT_FALSE(stand_on_table(box(10, 10, 10), {Mat3::Identity(), Vec3(0, 0, -1)}, "sunk"));
}

TEST(World, NoiseBelongsToThePlaceNotToTheTime) {
  const Solid part = standing_box(40, 40, 200);
  World one({}, part, 5), other({}, part, 5), another_seed({}, part, 6);
  one.set_laser(true, 0);
  another_seed.set_laser(true, 0);
  other.set_laser(true, 7 * kMs);
  one.set_mirrors(100, 200, 0);
  another_seed.set_mirrors(100, 200, 0);
  other.set_mirrors(-3000, 50, 8 * kMs);
  (void)other.sample(12 * kMs);
  other.set_mirrors(100, 200, 20 * kMs);
  for (int64_t k = 0; k < 20; ++k) {
    const World::Sample a = one.sample(10 * kMs + k * 30'000), b = other.sample(40 * kMs + k * 50'000);
    EXPECT_TRUE(equal(a, b)) << k;
    EXPECT_FALSE(equal(a, another_seed.sample(10 * kMs + k * 30'000))) << k;
  }
}

TEST(World, LightFallsOffObliquelyAndWithTheLaserOff) {
  // The beam at rest meets the front of a column at 35 degrees; turned by 45 it meets it at 54.6. Both
  // cameras see it.
  const Solid part = standing_box(60, 60, 200);
  WorldSetup setup;
  setup.numbers.ambient_A = 0;
  World world(setup, part, 1);
  for (int k = 0; k < setup.numbers.table_start_steps; ++k) world.step(Stage::table, false);
  for (int k = 0; k < setup.numbers.slide_start_steps; ++k) world.step(Stage::slide, false);
  world.set_mirrors(0, -8000, 0);
  EXPECT_NEAR(sum_of(world.sample(10 * kMs)[0]), 0, 10);
  world.set_laser(true, 10 * kMs);
  const int facing = sum_of(world.sample(20 * kMs)[0]);
  EXPECT_GT(facing, 1000);
  for (int k = 0; k < 4500; ++k) world.step(Stage::table, true);
  const int oblique = std::max(sum_of(world.sample(20 * kMs)[0]), sum_of(world.sample(20 * kMs)[1]));
  EXPECT_LT(oblique, facing);
  world.set_laser(false, 21 * kMs);
  EXPECT_NEAR(sum_of(world.sample(22 * kMs)[0]), 0, 10);
}

TEST(World, SwitchesCloseWhereTheLoadStands) {
  World world({}, standing_box(10, 10, 10), 1);
  const Numbers n;
  // Down: the motor first takes the play up.
  for (int k = n.slide_start_steps + n.slide_backlash_steps; k > n.slide_home_steps; --k) {
    EXPECT_FALSE(world.switches(0).slide_home);
    world.step(Stage::slide, false);
  }
  EXPECT_TRUE(world.switches(0).slide_home);
  EXPECT_FALSE(world.switches(0).slide_limit_low);
}

TEST(DrivenAxis, TakesUpItsPlayWhenItTurnsBack) {
  DrivenAxis axis(100, 3);
  for (int k = 0; k < 5; ++k) axis.step(true);
  EXPECT_EQ(axis.load_steps(), 105);
  for (int k = 0; k < 3; ++k) axis.step(false);
  EXPECT_EQ(axis.load_steps(), 105);
  axis.step(false);
  EXPECT_EQ(axis.load_steps(), 104);
  for (int k = 0; k < 3; ++k) axis.step(true);
  EXPECT_EQ(axis.load_steps(), 104);
  axis.step(true);
  EXPECT_EQ(axis.load_steps(), 105);
}

TEST(TrueGeometry, SpotOnTheAxisOfACameraIsInTheMiddleOfItsDetector) {
  const TrueGeometry g = nominal_geometry();
  for (const TrueCamera& camera : g.cameras) {
    const auto middle = image_on_detector(camera, {0, 0, 200});
    ASSERT_TRUE(middle);
    EXPECT_NEAR(middle->x, 0, 1e-12);
    EXPECT_NEAR(middle->y, 0, 1e-12);
    // 10 mm up along the plate is 35 / 378.8 of it on the detector.
    const Vec3 up(-std::sin(35 * std::acos(-1.0) / 180), 0, std::cos(35 * std::acos(-1.0) / 180));
    EXPECT_NEAR(image_on_detector(camera, Vec3(0, 0, 200) + 10 * up)->y, 10 * 35 / 378.837 / 10, 1e-5);
  }
  // Camera axes 45 degrees apart.
  const Vec3 a = g.cameras[0].T_camera_machine.R.row(2), b = g.cameras[1].T_camera_machine.R.row(2);
  EXPECT_NEAR(std::acos(a.dot(b)) * 180 / std::acos(-1.0), 45, 1e-9);
}

TEST(TrueGeometry, MirrorsTurnTheBeamTwiceAsFar) {
  const TrueGeometry g = nominal_geometry();
  const Line rest = beam_of_mirrors(g, 0, 0), up = beam_of_mirrors(g, 0, 0.01),
             aside = beam_of_mirrors(g, 0.01, 0);
  EXPECT_NEAR(rest.direction.z(), -std::sin(35 * std::acos(-1.0) / 180), 1e-12);
  EXPECT_NEAR(std::acos(rest.direction.dot(up.direction)), 0.02, 1e-9);
  EXPECT_GT(up.direction.z(), rest.direction.z());
  EXPECT_NEAR(std::acos(rest.direction.dot(aside.direction)), 0.02, 1e-9);
  EXPECT_GT(aside.direction.y(), 0);
}

TEST(ReadWorld, MovesWhatTheFileSays) {
  const TemporaryFile file(".json", R"({"camera_2": {"shift_mm": [0.1, 0, 0], "distortion": 0.005},
      "mirror_b": {"zero_deg": 0.5}, "light": {"part_albedo": 0.3}})");
  const auto world = read_world(file.path());
  ASSERT_TRUE(world) << world.error().message;
  const TrueGeometry nominal = nominal_geometry();
  const auto lens = [](const TrueCamera& c) { return c.T_camera_machine.inverse().t; };
  EXPECT_LT((lens(world->geometry.cameras[1]) - lens(nominal.cameras[1]) - Vec3(0.1, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(lens(world->geometry.cameras[0]), lens(nominal.cameras[0]));
  EXPECT_EQ(world->geometry.cameras[1].distortion, 0.005);
  EXPECT_NEAR(world->geometry.mirror_b.zero_rad, 0.5 * std::acos(-1.0) / 180, 1e-12);
  EXPECT_EQ(world->numbers.part_albedo, 0.3);
}

TEST(ReadWorld, ErrorsNameThePlace) {
  const std::pair<const char*, const char*> kCases[] = {
      {"nonsense", "JSON"},
      {R"({"camera_3": {}})", "camera_"},
      {R"({"camera_1": {"shift": [0, 0, 0]}})", "shift_mm"},
      {R"({"camera_1": {"shift_mm": [0, 0]}})", "three numbers"},
      {R"({"light": {"part_albedo": 2}})", "from 0 to 1"},
      {R"({"light": 3})", "object"},
      {R"({"stage": {"table_backlash_steps": 1.5}})", "whole number"},
      {R"({"electronics": {"converter_bits": 12.5}})", "whole number"},
  };
  for (const auto& [text, word] : kCases) {
    const TemporaryFile file(".json", text);
    const auto world = read_world(file.path());
    ASSERT_FALSE(world) << text;
    EXPECT_EQ(world.error().kind, ErrorKind::bad_input);
    EXPECT_NE(world.error().message.find(word), std::string::npos) << world.error().message;
  }
}

}  // namespace
}  // namespace tetragauge::sim
