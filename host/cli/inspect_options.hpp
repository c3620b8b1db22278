// SPDX-License-Identifier: GPL-3.0-or-later
// From scans to the report: what `inspect` and `measure` share.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/cli/input_options.hpp"
#include "host/inspect/inspect.hpp"
#include "host/report/measuring_story.hpp"
#include "host/report/report.hpp"

namespace tetragauge::cli {

struct InspectArguments {
  std::string tolerances, out;
  InspectOptions inspect;
  // Called with each report when it is written; its error is the command's.
  std::function<Status(const Report&)> on_report;

  void add(CLI::App& command);

  // Makes the folder `out` and checks, before the work, that the report and `more_files` can be written there
  // without writing over an input.
  Status prepare_folder(const Console& console, std::vector<std::string> inputs,
                        const std::vector<std::string>& more_files = {}) const;
  // The tolerance file, checked against the model.
  Result<Tolerances> read_limits(const Solid& model) const;

  // Inspects, writes the report into `out`, prints report.txt, puts report.json where --json asked. The exit
  // code.
  Result<int> run(const Console& console, std::span<const Scan> scans,
                  const std::vector<std::string>& scan_paths, const Solid& model,
                  const std::string& model_path, const Tolerances& tolerances) const;
  // The same for what is inspected already; `story`: how it was measured, if that is known.
  Result<int> report(const Console& console, const InspectionRun& inspection, std::span<const Scan> scans,
                     const std::vector<std::string>& scan_paths, const Solid& model,
                     const std::string& model_path, const Tolerances& tolerances,
                     const MeasuringStory* story = nullptr) const;
};

}  // namespace tetragauge::cli
