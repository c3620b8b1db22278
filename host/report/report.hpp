// SPDX-License-Identifier: GPL-3.0-or-later
// What a person and a program read: report.json (schema tetragauge/report/1), report.html, report.txt,
// faces.csv, deviation.ply.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "host/base/result.hpp"
#include "host/inspect/inspect.hpp"
#include "host/match/match_procrustes.hpp"
#include "host/match/pair_changes.hpp"
#include "host/report/measuring_story.hpp"

namespace tetragauge {

struct ReportFile {
  std::string name, sha256;  // the name as given; empty where there is no such file
};

// All that a report is written from.
struct Report {
  const InspectionRun& run;
  std::span<const Scan> scans;  // one per set-up
  const Solid& model;
  const Tolerances& tolerances;
  std::vector<ReportFile> scan_files;  // one per scan
  ReportFile model_file, tolerances_file;
  const MeasuringStory* story = nullptr;  // of a part that was just measured
};

// The files of write_report, in the order in which they appear: the verdict last.
inline constexpr std::array kReportFiles{"deviation.ply", "faces.csv", "report.html", "report.json",
                                         "report.txt"};

// Makes the folder and writes the files; each appears whole.
Status write_report(const std::filesystem::path& folder, const Report& report);

nlohmann::ordered_json report_json(const Report& report);
std::string report_text(const Report& report);  // verdict first; fits 100 columns
// Its beginning, without the tables of surface, distances and angles.
std::string summary_text(const Report& report);
std::string faces_csv(const Report& report);  // a face a line, RFC 4180, with a head line

nlohmann::ordered_json match_json(const Match& match,
                                  const std::string& method);  // shared with `match --json`
nlohmann::ordered_json procrustes_json(const ProcrustesMatch& procrustes);
nlohmann::ordered_json pair_changes_json(const PairChanges& changes);
// The block `reconstruction`; shared with `reconstruct --json`.
nlohmann::ordered_json reconstruction_json(const Scan& scan, const Reconstruction& reconstruction);

// Exit code of the command line for a verdict: 0 pass/none, 1 fail, 5 undecided or not measured.
int exit_code(Verdict verdict);

}  // namespace tetragauge
