// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/world.hpp"

#include <cmath>
#include <numbers>

#include "sim/noise.hpp"

namespace tetragauge::sim {
namespace {

// Which random number of a place is meant.
constexpr uint64_t kMirrorDraw = 1, kSpeckleDraw = 2, kSampleDraw = 16;
// Less light than this share of the laser's is none: a thousandth of a converter step.
constexpr double kDark = 1e-7;

}  // namespace

World::World(const WorldSetup& setup, const Solid& standing_part, uint64_t seed)
    : setup_(setup),
      part_(standing_part, setup.numbers.part_albedo, setup.numbers.table_albedo,
            setup.numbers.table_radius_mm),
      electronics_(setup.numbers),
      seed_(seed),
      mirror_a_(setup.numbers.mirror),
      mirror_b_(setup.numbers.mirror),
      table_steps_(setup.numbers.table_start_steps),
      slide_steps_(setup.numbers.slide_start_steps) {
  new_place();
}

void World::new_place() {
  uint64_t key = mix_bits(seed_);
  for (const int32_t part : {int32_t{a_code_}, int32_t{b_code_}, table_steps_, slide_steps_}) {
    key = combine_key(key, static_cast<uint64_t>(static_cast<int64_t>(part)));
  }
  place_key_ = key;
  sample_ = 0;
  const auto [na, nb] = normal_pair(combine_key(key, kMirrorDraw));
  a_error_rad_ = setup_.numbers.mirror_repeatability_rad * na;
  b_error_rad_ = setup_.numbers.mirror_repeatability_rad * nb;
  seen_.valid = false;
}

void World::set_mirrors(int16_t a_code, int16_t b_code, int64_t now_ns) {
  a_code_ = a_code;
  b_code_ = b_code;
  mirror_a_.command(a_code * setup_.numbers.rad_per_mirror_code, now_ns);
  mirror_b_.command(b_code * setup_.numbers.rad_per_mirror_code, now_ns);
  new_place();
}

void World::step(Stage stage, bool up) {
  (stage == Stage::table ? table_steps_ : slide_steps_) += up ? 1 : -1;
  new_place();
}

double World::lit(int64_t now_ns) const {
  const double t = static_cast<double>(now_ns - switched_ns_) * 1e-9;
  const double end = laser_on_ ? 1.0 : 0.0;
  return end + (lit_at_switch_ - end) * std::exp(-t / setup_.numbers.laser_rise_s);
}

void World::set_laser(bool on, int64_t now_ns) {
  lit_at_switch_ = lit(now_ns);
  switched_ns_ = now_ns;
  laser_on_ = on;
}

Switches World::switches() const {
  const Numbers& n = setup_.numbers;
  return {.table_home = table_steps_ <= n.table_home_steps,
          .slide_home = slide_steps_ <= n.slide_home_steps,
          .slide_limit_low = slide_steps_ <= n.slide_limit_low_steps,
          .slide_limit_high = slide_steps_ >= n.slide_limit_high_steps};
}

const SpotImages& World::spot(int64_t now_ns) {
  const double a = mirror_a_.angle_rad(now_ns), b = mirror_b_.angle_rad(now_ns);
  if (seen_.valid && a == seen_.a_rad && b == seen_.b_rad) return seen_.images;
  const Numbers& n = setup_.numbers;
  const Line beam = beam_of_mirrors(setup_.geometry, a + a_error_rad_, b + b_error_rad_);
  const double table_rad = 2 * std::numbers::pi * table_steps_ / n.table_steps_per_turn;
  const RigidTransform T_machine_part =
      table_pose(setup_.geometry, table_rad, slide_steps_ * n.slide_mm_per_step);
  seen_ = {true, a, b, image_spot(n, setup_.geometry, part_, T_machine_part, beam)};
  for (size_t c = 0; c < 2; ++c) {
    seen_.images[c] = add_speckle(n, setup_.geometry.cameras[c], seen_.images[c],
                                  combine_key(place_key_, kSpeckleDraw + c));
  }
  return seen_.images;
}

World::Sample World::sample(int64_t now_ns) {
  static constexpr SpotImages kNoLight{};
  const double on = lit(now_ns);
  const SpotImages& images = on > kDark ? spot(now_ns) : kNoLight;
  const uint64_t key = combine_key(place_key_, kSampleDraw + sample_++);
  return {electronics_.sample(images[0], on, combine_key(key, 0)),
          electronics_.sample(images[1], on, combine_key(key, 1))};
}

}  // namespace tetragauge::sim
