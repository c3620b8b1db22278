// SPDX-License-Identifier: GPL-3.0-or-later
// The options of a scan, and the session they lead to: a scan file, with its journal beside it meanwhile.
//
//   ScanArguments scan;
//   scan.add(*command);
//   scan.begin("scan.ply");                      // with --resume: takes up what was asked for then
//   auto measured = scan.measure(console);       // scan.ply is there
#pragma once

#include "host/cli/machine_options.hpp"
#include "host/session/default_plan.hpp"
#include "host/session/scan_journal.hpp"

namespace tetragauge::cli {

struct ScanArguments {
  MachineArguments machine;
  std::string plan, part_serial, operator_name;
  DefaultPlanOptions default_plan;
  bool keep_table = false, resume = false;

  void add(CLI::App& command);

  // Errors that can be known before a machine is touched: contradicting options, a journal of an interrupted
  // scan that nobody resumes, one of another scan.
  Status begin(const std::filesystem::path& out);
  // The files named; empty names are files not given. Known after begin().
  std::vector<std::string> input_files() const;
  // Opens the machine, scans, writes the scan, closes the machine. After an error, and after Ctrl-C (machine
  // aborted, laser off), what was measured is kept in the journal.
  Result<MeasuredScan> measure(const Console& console);

  // The same for more than a scan: opens the machine, with a journal in the options, has `work` measure, and
  // closes it. `work` calls keep() as soon as the scan is whole; until then an error leaves the journal.
  using SessionWork = std::function<Status(Link&, const ScanOptions&)>;
  Status in_session(const Console& console, const SessionWork& work);
  Status keep(const Scan& scan);
  // Ctrl-C or SIGTERM came in a session, which ended with an error.
  static bool was_stopped();
  // Of --plan; none where the journal has one.
  Result<std::optional<ScanPlan>> given_plan() const;

 private:
  // What a resumed scan has to know (scan_order.cpp).
  nlohmann::ordered_json order() const;
  Status take_order(const nlohmann::ordered_json& order);
  Status work_on_machine(const Console& console, const SessionWork& work);
  Error with_way_to_go_on(Error error) const;

  CLI::App* command_ = nullptr;
  std::filesystem::path out_;
  std::string start_time_;
  std::unique_ptr<ScanJournal> journal_;
};

// "77606 beams: 46051 points, ...; 244 s of the machine's time, 318 beams/s"
std::string counts_text(const ScanCounts& counts);
nlohmann::ordered_json counts_json(const ScanCounts& counts);

}  // namespace tetragauge::cli
