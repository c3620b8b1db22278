// SPDX-License-Identifier: GPL-3.0-or-later
// The physical world behind an emulated board: it takes what the board's pins do (mirror codes, laser, step
// edges) and gives what its converters and switches read. Times are virtual nanoseconds and never go back.
//
//   World world(setup, standing_part, seed);
//   world.set_mirrors(a, b, t);  world.set_laser(true, t);
//   auto codes = world.sample(t + 30000);   // both detectors
//
// All noise is a pure function of (seed, mirror codes, table and slide position, sample since set_mirrors,
// channel): a place visited twice gives the same samples, whatever happened in between.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/detector.hpp"
#include "sim/driven_axis.hpp"
#include "sim/faults.hpp"
#include "sim/mirror.hpp"
#include "sim/numbers.hpp"
#include "sim/part_on_table.hpp"
#include "sim/true_geometry.hpp"

namespace tetragauge::sim {

struct WorldSetup {
  TrueGeometry geometry = nominal_geometry();
  Numbers numbers;
  MachineFaults faults;
};

enum class Stage { table, slide };

struct Switches {
  bool table_home = false, slide_home = false;  // closed at and below the switch's edge
  bool slide_limit_low = false, slide_limit_high = false;
  bool interlock_closed = true;
  bool mirrors_good = true, laser_good = true;  // as their drivers say
};

class World {
 public:
  World(const WorldSetup& setup, const Solid& standing_part, uint64_t seed);

  void set_mirrors(int16_t a_code, int16_t b_code, int64_t now_ns);
  void set_laser(bool on, int64_t now_ns);
  void step(Stage stage, bool up);
  Switches switches(int64_t now_ns);
  // The next time after `now_ns` at which a fault changes a switch; the largest value when none does.
  int64_t next_switch_change_ns(int64_t now_ns) const;

  using Sample = std::array<DetectorCodes, 2>;
  Sample sample(int64_t now_ns);

 private:
  double lit(int64_t now_ns) const;
  double ambient(int64_t now_ns) const;  // of one detector, A
  void let_mirrors_stick(int64_t now_ns);
  void new_place();
  const SpotImages& spot(int64_t now_ns);

  WorldSetup setup_;
  PartOnTable part_;
  std::array<DetectorElectronics, 2> electronics_;
  uint64_t seed_;

  std::array<Mirror, 2> mirrors_;  // a, b
  struct Sticking {
    int64_t time_ns;
    size_t mirror;
    bool stuck;
  };
  std::vector<Sticking> sticking_;  // in order of time
  size_t sticking_done_ = 0;
  std::optional<int64_t> mirrors_off_since_ns_;
  int16_t a_code_ = 0, b_code_ = 0;
  bool laser_on_ = false;
  double lit_at_switch_ = 0;
  int64_t switched_ns_ = 0;
  DrivenAxis table_, slide_;

  uint64_t place_key_ = 0;
  uint64_t sample_ = 0;                       // since set_mirrors
  double a_error_rad_ = 0, b_error_rad_ = 0;  // repeatability, of this place
  // The spot last computed: mirrors at rest give the same one sample after sample.
  struct Seen {
    bool valid = false;
    double a_rad = 0, b_rad = 0;
    SpotImages images;
  } seen_;
};

}  // namespace tetragauge::sim
