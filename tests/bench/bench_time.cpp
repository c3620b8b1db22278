// SPDX-License-Identifier: GPL-3.0-or-later
// How long the host itself works on a main job, stage by stage: by the clock in its own stages, and by the
// processor in all. While the machine measures only the processor counts: the clock waits for the machine.
// What the main thread takes of the processor is what the clock shows on a computer with nothing else to do,
// whose other threads help it in time.
#include <tbb/task_arena.h>
#include <time.h>

#include <algorithm>
#include <cstdio>

#include "host/base/whole_file.hpp"
#include "host/report/report.hpp"
#include "host/scan/scan_file.hpp"
#include "tests/bench/machine_bench.hpp"

namespace tetragauge::bench {
namespace {

// CLOCK_PROCESS_CPUTIME_ID: all threads of this program; the emulator is another one.
double time_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct StageTime {
  std::string words;
  int times = 0;
  double clock_s = 0, main_thread_s = 0, processor_s = 0;
};

class Stopwatch {
 public:
  void begin(const std::string& words) {
    end();
    running_ = words;
    begun_ = now();
  }
  void end() {
    if (running_.empty()) return;
    auto stage = std::find_if(stages_.begin(), stages_.end(),
                              [&](const StageTime& known) { return known.words == running_; });
    if (stage == stages_.end()) stage = stages_.insert(stages_.end(), {running_});
    const StageTime ended = now();
    ++stage->times;
    stage->clock_s += ended.clock_s - begun_.clock_s;
    stage->main_thread_s += ended.main_thread_s - begun_.main_thread_s;
    stage->processor_s += ended.processor_s - begun_.processor_s;
    running_.clear();
  }
  const std::vector<StageTime>& stages() const { return stages_; }

 private:
  static StageTime now() {
    return {"", 0, time_s(CLOCK_MONOTONIC), time_s(CLOCK_THREAD_CPUTIME_ID),
            time_s(CLOCK_PROCESS_CPUTIME_ID)};
  }

  std::string running_;
  StageTime begun_;
  std::vector<StageTime> stages_;
};

bool bench_part(const MachinePart& part, const BenchOptions& options) {
  Stopwatch watch;
  BenchMachine bench = start_machine({.csg = part.good, .place = part.place, .faults = ""});
  watch.begin("reading the model");
  const Solid model = solid_of(part.good);
  Tolerances tolerances;
  tolerances.given = true;
  tolerances.by_default.profile_mm = 0.2;
  const std::filesystem::path folder = work_folder();
  MeasureOptions measure;
  measure.improve.rounds = options.rounds;
  measure.improve.plan.pitch_mm = options.pitch_mm;
  measure.keep_scan = [&](const Scan& scan, const ScanCounts&) {
    return write_scan(folder / "scan.ply", scan);
  };
  const auto measured =
      measure_part(*bench.link, model, tolerances, measure,
                   {.seed = 1, .on_stage = [&](const std::string& words) { watch.begin(words); }});
  if (!measured) {
    std::fprintf(stderr, "%s: %s\n", part.name.c_str(), measured.error().message.c_str());
    return false;
  }
  watch.begin("writing the report");
  const Report report{measured->run,
                      std::span(&measured->scan, 1),
                      model,
                      tolerances,
                      {{(folder / "scan.ply").string(), ""}},
                      {"model", ""},
                      {"tolerances", ""},
                      &measured->story};
  const Status written = write_report(folder, report);
  watch.end();
  if (!written) std::fprintf(stderr, "%s\n", written.error().message.c_str());

  std::printf("%s: %zu points, %zu rounds, %d threads\n", part.name.c_str(), measured->scan.size(),
              measured->story.rounds.size(), tbb::this_task_arena::max_concurrency());
  std::printf("%-34s %6s %12s %15s %14s\n", "stage", "times", "clock, s", "main thread, s", "processor, s");
  StageTime sum{"the host in all"};
  for (const StageTime& stage : watch.stages()) {
    const bool waits = stage.words == kMeasuring;
    char clock[40] = "waits";
    if (!waits) std::snprintf(clock, sizeof clock, "%.2f", stage.clock_s);
    std::printf("%-34s %6d %12s %15.2f %14.2f\n", stage.words.c_str(), stage.times, clock,
                stage.main_thread_s, stage.processor_s);
    // Nothing of measuring is hidden: it counts as if nothing else went on meanwhile.
    sum.clock_s += waits ? stage.processor_s : stage.clock_s;
    sum.main_thread_s += waits ? stage.processor_s : stage.main_thread_s;
    sum.processor_s += stage.processor_s;
  }
  std::printf("%-34s %6s %12.2f %15.2f %14.2f\n\n", sum.words.c_str(), "", sum.clock_s, sum.main_thread_s,
              sum.processor_s);
  return static_cast<bool>(written);
}

}  // namespace

int bench_time(const BenchOptions& options) {
  bool is_good = true;
  size_t count = 0;
  for (const MachinePart& part : machine_parts()) {
    if (options.parts.empty() ? part.name != "staircase" : !is_chosen(options, part)) continue;
    is_good = bench_part(part, options) && is_good;
    ++count;
  }
  return is_good && count > 0 ? 0 : 1;
}

}  // namespace tetragauge::bench
