// SPDX-License-Identifier: GPL-3.0-or-later
// What a person and a program read: report.json (schema tetragauge/report/1), report.txt, deviation.ply.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "host/base/result.hpp"
#include "host/inspect/inspect.hpp"

namespace tetragauge {

struct ReportInput {
  std::string scan_name, scan_sha256;  // file names as given
  std::string model_name, model_sha256;
  std::string tolerances_name, tolerances_sha256;  // empty without a tolerance file
};

nlohmann::ordered_json report_json(const InspectionRun& run, const Scan& scan, const Solid& model,
                                   const Tolerances& tolerances, const ReportInput& input);
nlohmann::ordered_json match_json(const Match& match,
                                  const std::string& method);  // shared with `match --json`
// The block `reconstruction`; shared with `reconstruct --json`.
nlohmann::ordered_json reconstruction_json(const Scan& scan, const Reconstruction& reconstruction);
std::string report_text(const InspectionRun& run, const Scan& scan, const Solid& model,
                        const Tolerances& tolerances,
                        const ReportInput& input);  // verdict first; fits 100 columns

// Makes the folder and writes the three files; each appears whole.
Status write_report(const std::filesystem::path& folder, const InspectionRun& run, const Scan& scan,
                    const Solid& model, const Tolerances& tolerances, const ReportInput& input);

// Exit code of the command line for a verdict: 0 pass/none, 1 fail, 5 undecided or not measured.
int exit_code(Verdict verdict);

}  // namespace tetragauge
