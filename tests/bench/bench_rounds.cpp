// SPDX-License-Identifier: GPL-3.0-or-later
// Parts with re-entrant corners and slots: what is in doubt before and after re-measurement, and whether it
// ends with nothing that a legal ray could still decide.
#include <cstdio>

#include "tests/bench/machine_bench.hpp"

namespace tetragauge::bench {
namespace {

constexpr int kRounds = 12;

bool bench_part(const MachinePart& part, const BenchOptions& bench_options) {
  BenchMachine bench =
      start_machine({.csg = part.good, .place = part.place, .faults = "", .seed = bench_options.seed});
  const Solid model = solid_of(part.good);
  Tolerances tolerances;
  tolerances.given = true;
  tolerances.by_default.profile_mm = 0.1;
  MeasureOptions options;
  options.improve.rounds = kRounds;
  const auto measured = measure_part(*bench.link, model, tolerances, options);
  if (!measured) {
    std::printf("%-25s %s\n", part.name.c_str(), measured.error().message.c_str());
    return false;
  }
  const auto& rounds = measured->story.rounds;
  if (rounds.empty()) {
    std::printf("%-25s %s\n", part.name.c_str(), measured->story.end.c_str());
    return true;
  }
  const Doubts &before = rounds.front().before, &after = rounds.back().after;
  size_t rays = 0, views = 0;
  double time = 0;
  for (const MeasuringRound& round : rounds) {
    rays += round.rays;
    views += round.views;
    time += round.machine_s;
  }
  std::printf("%-25s %6zu %5zu %6zu %6.0f %7.1f %7.1f %6zu %5zu %7.2f %6.2f %4zu %4zu %4zu %4zu\n",
              part.name.c_str(), rounds.size(), rays, views, time, before.doubtful_mm3, after.doubtful_mm3,
              before.resolvable, after.resolvable, before.resolvable_mm3, after.resolvable_mm3,
              before.undecided, after.undecided, before.not_measured, after.not_measured);
  std::fflush(stdout);
  return after.resolvable == 0 && after.undecided <= before.undecided &&
         after.not_measured <= before.not_measured;
}

}  // namespace

int bench_rounds(const BenchOptions& options) {
  std::printf("%-25s %6s %5s %6s %6s %7s %7s %6s %5s %7s %6s %4s %4s %4s %4s\n", "part", "rounds", "rays",
              "views", "s", "mm3", "after", "open", "after", "mm3", "after", "und.", "aft.", "n.m.", "aft.");
  bool is_good = true;
  for (const MachinePart& part : machine_parts())
    if (part.has_slots && is_chosen(options, part)) is_good = bench_part(part, options) && is_good;
  std::printf(
      "mm3 in doubt before and after the rounds; of it tetrahedra that a legal ray could still decide, and "
      "their mm3;\n"
      "faces undecided and not measured (profile_mm 0.1)\n");
  return is_good ? 0 : 1;
}

}  // namespace tetragauge::bench
