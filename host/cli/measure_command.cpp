// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <algorithm>
#include <array>

#include "host/base/whole_file.hpp"
#include "host/cli/batch_parts.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/cli/inspect_options.hpp"
#include "host/cli/plan_options.hpp"
#include "host/cli/scan_options.hpp"
#include "host/cli/unfinished_batch.hpp"
#include "host/history/history_file.hpp"
#include "host/history/summary.hpp"
#include "host/measure/measure_part.hpp"

namespace tetragauge::cli {
namespace {

constexpr const char* kScanFile = "scan.ply";  // in the folder of the report

struct MeasureArguments {
  InputOptions input;
  ScanArguments scan;
  PlanArguments plan;
  InspectArguments inspect;
  int rounds = ImproveOptions{}.rounds;
  double budget_s = 0;
  std::string history;

  void add(CLI::App& command) {
    scan.add(command);
    plan.add(command);
    input.add_model(command);
    input.add_unit(command);
    inspect.add(command);
    command
        .add_option("--rounds", rounds,
                    "Most rounds of going back to what is in doubt; 0: the first scan is judged as it is")
        ->check(CLI::Range(0, 100))
        ->capture_default_str();
    command
        .add_option("--budget", budget_s,
                    "Most time of the machine for all rounds, s; as long as they take unless given")
        ->check(CLI::Range(1.0, 1e6))
        ->type_name("S");
    command
        .add_option(
            "--history", history,
            "Keep each part in this file, which `history` shows; with --port one part after the other")
        ->type_name("DB")
        ->check(not_empty());
    command.get_option("--emulated")
        ->description("Emulated machine: model of the part as really made, or a folder of such models");
    command.footer(
        "A folder of parts, or --port with --history, is a batch: each part's report goes to DIR/PART, a "
        "table "
        "of\nthem ends it, and a part that cannot be measured does not lose the others. Emulated parts have "
        "the seeds\n--seed, --seed + 1, ... The exit code is the worst: 70, 4, 3, 2, 1, 5, 0. A folder's "
        "batch "
        "that was broken off is gone\non with by the same command with --resume: finished parts are kept, "
        "the "
        "broken one is measured from its beginning.");
  }

  bool is_folder() const {
    std::error_code ignored;
    return std::filesystem::is_directory(scan.machine.emulated.part, ignored);
  }
  bool is_batch() const { return is_folder() || (!history.empty() && !scan.machine.port.empty()); }

  MeasureOptions options(std::optional<ScanPlan> given) const {
    MeasureOptions out;
    out.plan = std::move(given);
    out.improve.rounds = rounds;
    out.improve.budget_s = budget_s;
    out.improve.plan = plan.options;
    out.improve.plan.pitch_mm = scan.default_plan.pitch_mm;
    out.improve.inspect = inspect.inspect;
    return out;
  }
};

// What the part should be.
struct Nominal {
  Solid model;
  Tolerances tolerances;
};

Result<Nominal> read_nominal(const Console& console, const MeasureArguments& arguments) {
  Result<Solid> model = arguments.input.read_model(console);
  if (!model) return model.error();
  Result<Tolerances> tolerances = arguments.inspect.read_limits(*model);
  if (!tolerances) return tolerances.error();
  return Nominal{std::move(*model), std::move(*tolerances)};
}

std::string scan_file(const MeasureArguments& arguments) {
  return (std::filesystem::path(arguments.inspect.out) / kScanFile).string();
}

Status prepare_one(const Console& console, MeasureArguments& arguments) {
  if (Status status = arguments.plan.check(); !status) return status;
  if (Status status = arguments.scan.begin(scan_file(arguments)); !status) return status;
  std::vector<std::string> inputs = arguments.scan.input_files();
  inputs.push_back(arguments.input.model);
  return arguments.inspect.prepare_folder(console, inputs, {kScanFile});
}

// One part: from the machine to the report. The exit code; after a round that broke off, its error: the
// report is there all the same.
Result<int> measure_one(const Console& console, MeasureArguments& arguments, const Nominal& nominal) {
  const std::string scan_path = scan_file(arguments);
  Result<std::optional<ScanPlan>> given = arguments.scan.given_plan();
  if (!given) return given.error();

  MeasureOptions options = arguments.options(std::move(*given));
  bool said = false;
  options.keep_scan = [&](const Scan& scan, const ScanCounts& counts) {
    if (!said) console.say(counts_text(counts));
    said = true;
    return arguments.scan.keep(scan);
  };
  std::optional<PartMeasurement> part;
  const Status done = arguments.scan.in_session(console, [&](Link& link, const ScanOptions& scan) -> Status {
    Result<PartMeasurement> measured = measure_part(link, nominal.model, nominal.tolerances, options, scan);
    if (!measured) return measured.error();
    part = std::move(*measured);
    return Done{};
  });
  if (!done) return done.error();
  Result<int> code =
      arguments.inspect.report(console, part->run, std::span(&part->scan, 1), {scan_path}, nominal.model,
                               arguments.input.model, nominal.tolerances, &part->story);
  if (!code || !part->interruption) return code;
  Error error = *part->interruption;
  error.message += "\nre-measuring was broken off; the report in " + arguments.inspect.out +
                   " is judged from what was measured before; measure the part anew to have all its rounds";
  return error;
}

Result<std::string> sha256_or_none(const std::string& path) {
  if (path.empty()) return std::string();
  Result<std::string> content = read_whole_file(path);
  if (!content) return content.error();
  return sha256_hex(*content);
}

// The parts measured by this run, kept in the history file where one is named.
class PartKeeper {
 public:
  static Result<PartKeeper> open(const MeasureArguments& arguments) {
    PartKeeper keeper;
    const std::array<std::pair<std::string PartRecord::*, const std::string*>, 3> files{
        {{&PartRecord::model_sha256, &arguments.input.model},
         {&PartRecord::tolerances_sha256, &arguments.inspect.tolerances},
         {&PartRecord::plan_sha256, &arguments.scan.plan}}};
    for (const auto& [member, path] : files) {
      Result<std::string> sha = sha256_or_none(*path);
      if (!sha) return sha.error();
      keeper.common_.*member = *sha;
    }
    keeper.common_.model_name = arguments.input.model;
    keeper.common_.software = kVersion;
    keeper.common_.operator_name = arguments.scan.operator_name;
    if (arguments.history.empty()) return keeper;
    Result<HistoryFile> file = HistoryFile::open_to_add(arguments.history);
    if (!file) return file.error();
    keeper.file_ = std::move(*file);
    Result<std::vector<PartRecord>> before = keeper.file_->parts();
    if (!before) return before.error();
    if (!before->empty()) keeper.next_ = before->back().number + 1;
    return keeper;
  }

  int64_t next_number() const { return next_; }
  const std::vector<PartRecord>& parts() const { return parts_; }

  Status add_measured(const std::string& name, const Report& report) {
    PartRecord record = record_of(report);
    record.part = name;
    record.plan_sha256 = common_.plan_sha256;
    record.software = common_.software;
    return add(std::move(record));
  }
  Status add_unmeasured(const std::string& name, std::optional<uint64_t> seed, const std::string& why) {
    PartRecord record = common_;
    record.part = name;
    record.seed = seed;
    record.verdict = Verdict::not_measured;
    record.reason = why;
    return add(std::move(record));
  }
  // A part that an earlier run has finished, as the file has it.
  Status recall(const std::string& name, int64_t number) {
    Result<std::vector<PartRecord>> kept = file_->parts();
    if (!kept) return kept.error();
    for (PartRecord& record : *kept) {
      if (record.number != number || record.part != name) continue;
      parts_.push_back(std::move(record));
      return Done{};
    }
    return bad_input(name +
                     ": the batch has finished it, but it is not in this history; name the --history " +
                     "that the batch was begun with");
  }
  const PartRecord& common() const { return common_; }
  // The file's parts of this model.
  Result<std::vector<ModelHistory>> history() {
    if (!file_) return std::vector<ModelHistory>{};
    Result<std::vector<PartRecord>> parts = file_->parts();
    if (!parts) return parts.error();
    std::erase_if(*parts, [&](const PartRecord& part) { return part.model_sha256 != common_.model_sha256; });
    return summarise(*parts);
  }

 private:
  PartKeeper() = default;

  Status add(PartRecord record) {
    record.number = next_;
    if (file_) {
      const Result<int64_t> number = file_->add(record);
      if (!number) return number.error();
      record.number = *number;
    }
    next_ = record.number + 1;
    parts_.push_back(std::move(record));
    return Done{};
  }

  PartRecord common_;
  std::optional<HistoryFile> file_;
  int64_t next_ = 1;
  std::vector<PartRecord> parts_;
};

// Of a part that could not be measured: there is no going on with half a part, the next stands there soon.
// An emulated machine's device has another name in every run, and would make equal runs differ.
std::string reason_of(const Error& error, bool is_emulated) {
  const std::string why = error.message.substr(0, error.message.find("\nwhat was measured so far"));
  const size_t device_end = why.find(": ");
  return is_emulated && why.starts_with("unix:") && device_end != std::string::npos
             ? why.substr(device_end + 2)
             : why;
}

int worse_code(int a, int b) {
  constexpr std::array kOrder{0, 5, 1, 2, 3, 4, 70};
  const auto rank = [&](int code) { return std::find(kOrder.begin(), kOrder.end(), code); };
  return rank(a) < rank(b) ? b : a;
}

bool is_stopped_report(const Report& report) {
  return ScanArguments::was_stopped() && report.story && !report.story->interruption.empty();
}

// The part as a row, whatever came of it; its exit code. A part that was stopped is no row yet when the batch
// can be gone on with. Errors: the row could not be kept.
Result<int> measure_for_batch(const Console& console, MeasureArguments& arguments, const Nominal& nominal,
                              const BatchPart& part, PartKeeper& keeper, bool can_be_resumed) {
  arguments.inspect.out = part.folder.string();
  arguments.scan.part_serial = part.name;
  bool is_kept = false;
  std::optional<Error> lost;
  arguments.inspect.on_report = [&](const Report& report) -> Status {
    if (can_be_resumed && is_stopped_report(report)) return Done{};
    Status kept = keeper.add_measured(part.name, report);
    is_kept = true;
    if (!kept) lost = kept.error();
    return kept;
  };
  Result<int> code = Result<int>(0);
  if (Status status = prepare_one(console, arguments); !status) {
    code = status.error();
  } else {
    code = measure_one(console, arguments, nominal);
  }
  arguments.inspect.on_report = nullptr;
  if (lost) return *lost;
  if (code) {
    console.say(part.name + ": " + std::string(verdict_name(keeper.parts().back().verdict)));
    return code;
  }
  const bool is_emulated = arguments.scan.machine.port.empty();
  const std::string why = reason_of(code.error(), is_emulated);
  console.say(part.name + ": " + why);
  std::error_code ignored;
  std::filesystem::remove(journal_of(scan_file(arguments)), ignored);
  if (!is_kept && !(can_be_resumed && ScanArguments::was_stopped())) {
    const std::optional<uint64_t> seed =
        is_emulated ? std::optional(arguments.scan.machine.emulated.seed) : std::nullopt;
    if (Status kept = keeper.add_unmeasured(part.name, seed, why); !kept) return kept.error();
  }
  return static_cast<int>(code.error().kind);
}

// What must be the same when a batch is gone on with.
nlohmann::ordered_json order_of(const MeasureArguments& arguments, const PartRecord& common) {
  return {{"--model", common.model_sha256}, {"--tolerances", common.tolerances_sha256},
          {"--plan", common.plan_sha256},   {"--seed", arguments.scan.machine.emulated.seed},
          {"--rounds", arguments.rounds},   {"--budget", arguments.budget_s}};
}

// One part after the other. The worst of their exit codes.
Result<int> measure_batch(const Console& console, MeasureArguments& arguments) {
  const bool resumes = arguments.scan.resume;
  if (resumes && (!arguments.is_folder() || arguments.history.empty()))
    return usage_error(
        "--resume goes on with a batch of a folder that has a --history; at a machine measure the part anew");
  arguments.scan.resume = false;  // no part of it is gone on with
  const bool asks = !arguments.is_folder() && ::isatty(STDIN_FILENO) != 0;
  if (!arguments.scan.part_serial.empty() && (arguments.is_folder() || asks))
    return usage_error("--part-serial is for one part; in a batch each part has its own");
  if (Status status = check_outputs(console, {}, {arguments.input.model, arguments.history}); !status)
    return status.error();
  Result<Nominal> nominal = read_nominal(console, arguments);
  if (!nominal) return nominal.error();
  const std::filesystem::path out = arguments.inspect.out;
  std::error_code ignored;  // where it matters, the first part's folder says so
  std::filesystem::create_directories(out, ignored);
  Result<PartKeeper> keeper = PartKeeper::open(arguments);
  if (!keeper) return keeper.error();
  std::vector<BatchPart> parts;
  if (arguments.is_folder()) {
    Result<std::vector<BatchPart>> found = parts_in_folder(arguments.scan.machine.emulated.part, out);
    if (!found) return found.error();
    parts = std::move(*found);
  } else if (!asks) {
    const std::string& serial = arguments.scan.part_serial;
    parts.push_back(part_named(serial.empty() ? std::to_string(keeper->next_number()) : serial, out));
  }
  std::optional<UnfinishedBatch> batch;
  if (arguments.is_folder() && !arguments.history.empty()) {
    const nlohmann::ordered_json order = order_of(arguments, keeper->common());
    Result<UnfinishedBatch> opened =
        resumes ? UnfinishedBatch::reopen(out, order) : UnfinishedBatch::begin(out, order);
    if (!opened) return opened.error();
    batch = std::move(*opened);
  }
  Console of_part = console;  // its JSON and its text are in its report
  of_part.json.clear();
  of_part.keeps_stdout = true;
  int worst = 0;
  const uint64_t seed = arguments.scan.machine.emulated.seed;
  for (size_t k = 0; asks || k < parts.size(); ++k) {
    std::optional<BatchPart> part = asks ? ask_for_part(keeper->next_number(), out) : parts[k];
    if (!part) break;
    if (resumes) {
      if (const auto done = batch->finished().find(part->name); done != batch->finished().end()) {
        if (Status known = keeper->recall(part->name, done->second.number); !known) return known.error();
        worst = worse_code(worst, done->second.exit_code);
        console.say(part->name + ": measured before, kept");
        continue;
      }
      if (part->name == batch->broken_off()) {
        console.say(part->name + ": was broken off, measured from its beginning");
        std::filesystem::remove(journal_of(part->folder / kScanFile), ignored);
      }
    }
    // Equal seeds would give all parts the same noise, and a spread that is too small.
    arguments.scan.machine.emulated.seed = seed + k;
    arguments.scan.machine.emulated.part = part->model;
    if (parts.size() > 1)
      console.say("part " + std::to_string(k + 1) + " of " + std::to_string(parts.size()) + ": " +
                  part->name);
    if (batch)
      if (Status begun = batch->begin_part(part->name); !begun) return begun.error();
    Result<int> code = measure_for_batch(of_part, arguments, *nominal, *part, *keeper, batch.has_value());
    if (!code) return code;
    worst = worse_code(worst, *code);
    const bool was_broken_off = ScanArguments::was_stopped() && *code == static_cast<int>(ErrorKind::machine);
    if (batch && !was_broken_off)
      if (Status kept = batch->end_part(part->name, {keeper->parts().back().number, *code}); !kept)
        return kept.error();
    if (ScanArguments::was_stopped()) break;
  }
  if (batch && batch->finished().size() == parts.size()) {
    batch->remove();
  } else if (batch) {
    console.say(std::to_string(batch->finished().size()) + " of " + std::to_string(parts.size()) +
                " parts are finished; go on by repeating the command with --resume");
  }
  if (keeper->parts().empty()) return worst;
  if (Status status = console.put_json(history_json(summarise(keeper->parts()), 0)); !status)
    return status.error();
  Result<std::vector<ModelHistory>> history = keeper->history();
  if (!history) return history.error();
  for (const ModelHistory& model : *history) console.print(history_text(model, {}) + "\n");
  console.print(parts_table(keeper->parts()));
  return worst;
}

// One part, kept in the history where one is named.
Result<int> measure_single(const Console& console, MeasureArguments& arguments) {
  std::error_code ignored;
  const std::string scan_path = scan_file(arguments);
  if (arguments.scan.resume && std::filesystem::exists(scan_path, ignored) &&
      !std::filesystem::exists(journal_of(scan_path), ignored)) {
    return bad_input(scan_path +
                     ": the scan is whole; rounds of re-measurement that were broken off cannot be " +
                     "gone on with, measure the part anew without --resume");
  }
  if (Status status = prepare_one(console, arguments); !status) return status.error();
  Result<Nominal> nominal = read_nominal(console, arguments);
  if (!nominal) return nominal.error();
  if (arguments.history.empty()) return measure_one(console, arguments, *nominal);
  Result<PartKeeper> keeper = PartKeeper::open(arguments);
  if (!keeper) return keeper.error();
  const std::string serial = arguments.scan.part_serial;
  const std::string name = serial.empty() ? arguments.scan.machine.emulated.part.filename().string() : serial;
  arguments.inspect.on_report = [&](const Report& report) { return keeper->add_measured(name, report); };
  // A part that can be gone on with (--resume) is no row yet.
  return measure_one(console, arguments, *nominal);
}

}  // namespace

void add_measure(CLI::App& app, Console& console, Run& run) {
  auto arguments = std::make_shared<MeasureArguments>();
  CLI::App* command =
      add_command(app, console, "measure",
                  "The main job: scan with a machine, inspect, go back to what is in doubt, report");
  arguments->add(*command);
  command->callback([arguments, &console, &run] {
    run = [arguments, &console] {
      return arguments->is_batch() ? measure_batch(console, *arguments) : measure_single(console, *arguments);
    };
  });
}

}  // namespace tetragauge::cli
