// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/scan_options.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <ctime>

#include "host/cli/progress_line.hpp"
#include "host/scan/scan_file.hpp"

namespace tetragauge::cli {
namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

// While it lives, Ctrl-C and SIGTERM ask the session to stop instead of killing it with the laser on.
class StopOnSignal {
 public:
  StopOnSignal() {
    struct sigaction action {};
    action.sa_handler = [](int) { stop_requested = true; };
    sigaction(SIGINT, &action, &old_interrupt_);
    sigaction(SIGTERM, &action, &old_terminate_);
  }
  ~StopOnSignal() {
    sigaction(SIGINT, &old_interrupt_, nullptr);
    sigaction(SIGTERM, &old_terminate_, nullptr);
  }
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

 private:
  struct sigaction old_interrupt_ {
  }, old_terminate_{};
};

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace

std::string counts_text(const ScanCounts& counts) {
  std::string text = std::to_string(counts.beams) + " beams: " + std::to_string(counts.points) + " points, " +
                     std::to_string(counts.table_points) + " on the table dropped";
  const std::string rejected = rejected_text(counts);
  if (!rejected.empty()) text += ", rejected " + rejected;
  char rate[80];
  if (counts.machine_time_s > 0) {
    std::snprintf(rate, sizeof rate, "; %.0f s of the machine's time, %.0f beams/s", counts.machine_time_s,
                  static_cast<double>(counts.timed_beams) / counts.machine_time_s);
    text += rate;
  }
  return text;
}

void ScanArguments::add(CLI::App& command) {
  command_ = &command;
  machine.add(command);
  auto* plan_option =
      command.add_option("--plan", plan, "Scan plan (JSON); without one a survey finds the part")
          ->type_name("P.json");
  command.add_option("--pitch", default_plan.pitch_mm, "Spacing of the beams without a plan, mm")
      ->check(CLI::Range(0.05, 20.0))
      ->capture_default_str()
      ->excludes(plan_option);
  command.add_flag("--keep-table", keep_table, "Keep points on the table's top");
  command.add_option("--part-serial", part_serial, "The part's serial number, for the scan's header")
      ->type_name("TEXT");
  command.add_option("--operator", operator_name, "Who measures, for the scan's header")->type_name("TEXT");
  command.add_flag("--resume", resume,
                   "Go on with an interrupted scan; its journal beside the scan file says everything else");
}

bool ScanArguments::was_stopped() {
  return stop_requested;
}

Status ScanArguments::begin(const std::filesystem::path& out) {
  out_ = out;
  journal_.reset();  // of the part before
  const std::filesystem::path path = journal_of(out);
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) {
    auto reopened = ScanJournal::reopen(path);
    if (!reopened) return reopened.error();
    journal_ = std::move(*reopened);
    if (!resume && journal_->items() > 0) {
      return bad_input(path.string() +
                       ": an interrupted scan; go on with it by --resume, or move that file " +
                       "away to scan anew");
    }
    // Killed before anything was measured, or even before it was kept what to measure.
    if (!resume || journal_->order().is_null()) {
      journal_->remove();
      journal_.reset();
    }
  }
  if (resume && !journal_) {
    return bad_input(path.string() + ": there is no interrupted scan to go on with; " +
                     (std::filesystem::exists(out, ignored) ? out.string() + " is a finished one"
                                                            : "scan without --resume"));
  }
  if (resume) {
    if (const Status taken = take_order(journal_->order()); !taken) return taken;
  }
  return machine.check();
}

std::vector<std::string> ScanArguments::input_files() const {
  return {plan, machine.emulated.part.string(), machine.emulated.world.string()};
}

Error ScanArguments::with_way_to_go_on(Error error) const {
  error.message += "\nwhat was measured so far is kept in " + journal_->path().string() +
                   "; go on by repeating the command with --resume";
  return error;
}

Result<std::optional<ScanPlan>> ScanArguments::given_plan() const {
  if (plan.empty() || (journal_ && journal_->plan())) return std::optional<ScanPlan>{};
  Result<ScanPlan> read = read_plan(plan);
  if (!read) return read.error();
  return std::optional(std::move(*read));
}

Status ScanArguments::keep(const Scan& scan) {
  if (Status written = write_scan(out_, scan); !written)
    return journal_ ? with_way_to_go_on(written.error()) : written.error();
  if (journal_) journal_->remove();
  journal_.reset();
  return Done{};
}

Status ScanArguments::in_session(const Console& console, const SessionWork& work) {
  if (!journal_) {
    start_time_ = utc_now();
    auto begun = ScanJournal::begin(journal_of(out_), order());
    if (!begun) return begun.error();
    journal_ = std::move(*begun);
  } else if (journal_->bytes_cut() > 0) {
    console.say(journal_->path().string() + ": its last " + std::to_string(journal_->bytes_cut()) +
                " bytes are damaged; what was in them is measured again");
  }
  const Status done = work_on_machine(console, work);
  if (!journal_) return done;  // the scan is kept
  if (!done && journal_->items() > 0) return with_way_to_go_on(done.error());
  journal_->remove();
  return done;
}

Status ScanArguments::work_on_machine(const Console& console, const SessionWork& work) {
  StopOnSignal stop_on_signal;
  console.begin_stage(machine.port.empty() ? "starting the emulated machine" : "connecting to the machine");
  Result<OpenMachine> opened = machine.open();
  if (!opened) return opened.error();
  Link& link = *opened->link;
  ProgressLine progress_line(!console.quiet && ::isatty(STDERR_FILENO));
  ScanOptions options;
  options.keep_table = keep_table;
  options.part_serial = part_serial;
  options.operator_name = operator_name;
  const bool emulated = (link.machine().capabilities & tg_Capability_CAPABILITY_EMULATED) != 0;
  if (!emulated) options.start_time = start_time_;
  if (opened->emulated) options.seed = machine.emulated.seed;
  options.stop = &stop_requested;
  options.journal = journal_.get();
  options.log = [&](const std::string& line) {
    progress_line.end();
    console.say(line);
  };
  options.on_progress = [&](const ScanProgress& progress) {
    console.end_stage();
    progress_line.show(progress);
  };
  options.on_stage = [&](const std::string& words) {
    progress_line.end();
    console.begin_stage(words);
  };
  const Status done = work(link, options);
  progress_line.end();
  return done ? done : Status(opened->explain(done.error()));
}

Result<MeasuredScan> ScanArguments::measure(const Console& console) {
  Result<std::optional<ScanPlan>> given = given_plan();
  if (!given) return given.error();
  std::optional<MeasuredScan> out;
  const Status done = in_session(console, [&](Link& link, const ScanOptions& options) -> Status {
    const bool is_resumed = options.journal->plan().has_value();
    if (!is_resumed && !*given) {
      Result<ScanPlan> laid_out = tetragauge::default_plan(link, default_plan, options);
      if (!laid_out) return laid_out.error();
      *given = std::move(*laid_out);
    }
    Result<MeasuredScan> measured =
        is_resumed ? resume_scan(link, options) : run_scan(link, **given, options);
    if (!measured) return measured.error();
    options.log(counts_text(measured->counts));
    out = std::move(*measured);
    return keep(out->scan);
  });
  if (!done) return done.error();
  return std::move(*out);
}

nlohmann::ordered_json counts_json(const ScanCounts& counts) {
  nlohmann::ordered_json rejected = nlohmann::ordered_json::object();
  for (size_t reason = 1; reason < counts.rejected.size(); ++reason)
    if (*reject_word(reason) != '\0') rejected[reject_word(reason)] = counts.rejected[reason];
  return {{"schema", "tetragauge/scan/1"},
          {"beams", counts.beams},
          {"points", counts.points},
          {"table_points_dropped", counts.table_points},
          {"rejected", rejected},
          {"unsettled", counts.unsettled},
          {"one_camera", counts.one_camera},
          {"machine_time_s", counts.machine_time_s}};
}

}  // namespace tetragauge::cli
