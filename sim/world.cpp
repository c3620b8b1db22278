// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/noise.hpp"

namespace tetragauge::sim {
namespace {

// Which random number of a place is meant.
constexpr uint64_t kMirrorDraw = 1, kSpeckleDraw = 2, kSampleDraw = 16;
// Less light than this share of the laser's is none: a thousandth of a converter step.
constexpr double kDark = 1e-7;
// A mirror driver reports a mirror that stands off its target by more than this for so long: longer than any
// step takes, and less than the spacing of a usual raster (1 mm at 350 mm is 1.4 mrad).
constexpr double kMirrorOff_rad = 1e-3;
constexpr int64_t kMirrorOff_ns = 5'000'000;

}  // namespace

World::World(const WorldSetup& setup, const Solid& standing_part, uint64_t seed)
    : setup_(setup),
      part_(standing_part, setup.numbers.part_albedo,
            {setup.geometry.table_top_normal, setup.numbers.table_radius_mm, setup.numbers.table_albedo}),
      electronics_{DetectorElectronics(setup.numbers, 0), DetectorElectronics(setup.numbers, 1)},
      seed_(seed),
      mirrors_{Mirror(setup.numbers.mirror), Mirror(setup.numbers.mirror)},
      table_(setup.numbers.table_start_steps, setup.numbers.table_backlash_steps),
      slide_(setup.numbers.slide_start_steps, setup.numbers.slide_backlash_steps) {
  for (size_t m = 0; m < mirrors_.size(); ++m) {
    for (const TimeSpan& span : setup.faults.mirror_stuck[m]) {
      sticking_.push_back({span.from_ns, m, true});
      sticking_.push_back({span.until_ns, m, false});
    }
  }
  std::stable_sort(sticking_.begin(), sticking_.end(),
                   [](const Sticking& a, const Sticking& b) { return a.time_ns < b.time_ns; });
  new_place();
}

void World::new_place() {
  uint64_t key = mix_bits(seed_);
  for (const int32_t part : {int32_t{a_code_}, int32_t{b_code_}, table_.load_steps(), slide_.load_steps()}) {
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
  let_mirrors_stick(now_ns);
  mirrors_[0].command(a_code * setup_.numbers.rad_per_mirror_code, now_ns);
  mirrors_[1].command(b_code * setup_.numbers.rad_per_mirror_code, now_ns);
  let_mirrors_stick(now_ns);
  new_place();
}

void World::let_mirrors_stick(int64_t now_ns) {
  for (; sticking_done_ < sticking_.size() && sticking_[sticking_done_].time_ns <= now_ns; ++sticking_done_) {
    const Sticking& change = sticking_[sticking_done_];
    if (change.stuck) {
      mirrors_[change.mirror].stick(change.time_ns);
    } else {
      mirrors_[change.mirror].release(change.time_ns);
    }
  }
  if (std::max(mirrors_[0].stuck_off_rad(), mirrors_[1].stuck_off_rad()) <= kMirrorOff_rad) {
    mirrors_off_since_ns_.reset();
  } else if (!mirrors_off_since_ns_) {
    mirrors_off_since_ns_ = now_ns;
  }
}

void World::step(Stage stage, bool up) {
  (stage == Stage::table ? table_ : slide_).step(up);
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

Switches World::switches(int64_t now_ns) {
  let_mirrors_stick(now_ns);
  const Numbers& n = setup_.numbers;
  const MachineFaults& f = setup_.faults;
  const int32_t table = table_.load_steps(), slide = slide_.load_steps();
  return {.table_home = table <= n.table_home_steps,
          .slide_home = slide <= n.slide_home_steps,
          .slide_limit_low = slide <= n.slide_limit_low_steps || any_holds(f.limit_low, now_ns),
          .slide_limit_high = slide >= n.slide_limit_high_steps || any_holds(f.limit_high, now_ns),
          .interlock_closed = !any_holds(f.interlock_open, now_ns),
          .mirrors_good = !mirrors_off_since_ns_ || now_ns - *mirrors_off_since_ns_ < kMirrorOff_ns,
          .laser_good = !any_holds(f.laser_failing, now_ns)};
}

int64_t World::next_switch_change_ns(int64_t now_ns) const {
  const MachineFaults& f = setup_.faults;
  int64_t next = std::numeric_limits<int64_t>::max();
  for (const auto* spans : {&f.interlock_open, &f.limit_low, &f.limit_high, &f.laser_failing}) {
    for (const TimeSpan& span : *spans) {
      if (span.from_ns > now_ns) next = std::min(next, span.from_ns);
      if (span.until_ns > now_ns) next = std::min(next, span.until_ns);
    }
  }
  return next;
}

const SpotImages& World::spot(int64_t now_ns) {
  const double a = mirrors_[0].angle_rad(now_ns), b = mirrors_[1].angle_rad(now_ns);
  if (seen_.valid && a == seen_.a_rad && b == seen_.b_rad) return seen_.images;
  const Numbers& n = setup_.numbers;
  const Line beam = beam_of_mirrors(setup_.geometry, a + a_error_rad_, b + b_error_rad_);
  const double table_rad = 2 * std::numbers::pi * table_.load_steps() / n.table_steps_per_turn;
  const RigidTransform T_machine_part =
      table_pose(setup_.geometry, table_rad, slide_.load_steps() * n.slide_mm_per_step);
  seen_ = {true, a, b, image_spot(n, setup_.geometry, part_, T_machine_part, beam)};
  for (size_t c = 0; c < 2; ++c) {
    seen_.images[c] = add_speckle(n, setup_.geometry.cameras[c], seen_.images[c],
                                  combine_key(place_key_, kSpeckleDraw + c));
  }
  return seen_.images;
}

double World::ambient(int64_t now_ns) const {
  const Numbers& n = setup_.numbers;
  const double t = static_cast<double>(now_ns) * 1e-9;
  double current_A = n.ambient_A + n.ambient_drift_A_s * t;
  if (n.ambient_flicker > 0) current_A *= 1 + n.ambient_flicker * std::sin(2 * std::numbers::pi * 100 * t);
  for (const Flash& flash : setup_.faults.flashes)
    current_A += flash.when.holds(now_ns) ? flash.current_A : 0;
  return current_A;
}

World::Sample World::sample(int64_t now_ns) {
  static constexpr SpotImages kNoLight{};
  let_mirrors_stick(now_ns);
  const MachineFaults& f = setup_.faults;
  const bool dark = any_holds(f.laser_failing, now_ns) || any_holds(f.laser_dark, now_ns);
  const double on = dark ? 0 : lit(now_ns);
  const SpotImages& images = on > kDark ? spot(now_ns) : kNoLight;
  const double ambient_A = ambient(now_ns);
  const uint64_t key = combine_key(place_key_, kSampleDraw + sample_++);
  Sample codes{electronics_[0].sample(images[0], on, ambient_A, combine_key(key, 0)),
               electronics_[1].sample(images[1], on, ambient_A, combine_key(key, 1))};
  for (const RailedChannel& railed : f.railed) {
    if (!railed.when.holds(now_ns)) continue;
    DetectorCodes& c = codes[railed.camera];
    int16_t* const channels[] = {&c.x1, &c.x2, &c.y1, &c.y2};
    *channels[railed.channel] = std::numeric_limits<int16_t>::max();
  }
  return codes;
}

}  // namespace tetragauge::sim
