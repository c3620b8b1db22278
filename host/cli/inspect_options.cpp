// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/inspect_options.hpp"

#include <unistd.h>

#include "host/base/whole_file.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/report/report.hpp"
#include "host/report/terminal_text.hpp"

namespace tetragauge::cli {
namespace {

Result<std::string> sha256_of(const std::string& path) {
  Result<std::string> content = read_whole_file(path);
  if (!content) return content.error();
  return sha256_hex(*content);
}

}  // namespace

void InspectArguments::add(CLI::App& command) {
  command.add_option("--tolerances", tolerances, "Tolerance file (JSON); without one there is no verdict")
      ->type_name("T.json");
  command
      .add_option("--out", out, "Folder for report.html, report.txt, report.json, faces.csv, deviation.ply")
      ->required()
      ->type_name("DIR")
      ->check(not_empty());
  command.add_option("--rule", inspect.rule, "Decision rule: guarded, iso14253-1:2017 or simple")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Rule>{{"guarded", Rule::guarded},
                                                                      {"iso14253-1:2017", Rule::iso14253},
                                                                      {"simple", Rule::simple}})
                      .description(""))
      ->type_name("RULE")
      ->default_str(std::string(rule_name(inspect.rule)));
}

Status InspectArguments::prepare_folder(const Console& console, std::vector<std::string> inputs,
                                        const std::vector<std::string>& more_files) const {
  std::error_code code;
  std::filesystem::create_directories(out, code);
  if (code || ::access(out.c_str(), W_OK) != 0) {
    return usage_error("cannot make the folder " + out +
                       (code ? ": " + code.message() : ": no permission to write in it"));
  }
  std::vector<std::string> outputs;
  for (const char* name : kReportFiles) outputs.push_back((std::filesystem::path(out) / name).string());
  for (const std::string& name : more_files) outputs.push_back((std::filesystem::path(out) / name).string());
  inputs.push_back(tolerances);
  return check_outputs(console, outputs, inputs);
}

Result<Tolerances> InspectArguments::read_limits(const Solid& model) const {
  if (tolerances.empty()) return Tolerances{};
  return read_tolerances(tolerances, model.list);
}

Result<int> InspectArguments::run(const Console& console, std::span<const Scan> scans,
                                  const std::vector<std::string>& scan_paths, const Solid& model,
                                  const std::string& model_path, const Tolerances& limits) const {
  InspectOptions options = inspect;
  options.on_stage = [&](const std::string& words) { console.begin_stage(words); };
  Result<InspectionRun> inspection = tetragauge::inspect(scans, model, limits, options);
  if (!inspection) return inspection.error();
  return report(console, *inspection, scans, scan_paths, model, model_path, limits);
}

Result<int> InspectArguments::report(const Console& console, const InspectionRun& inspection,
                                     std::span<const Scan> scans, const std::vector<std::string>& scan_paths,
                                     const Solid& model, const std::string& model_path,
                                     const Tolerances& limits, const MeasuringStory* story) const {
  Report report{inspection, scans, model, limits, {}, {model_path, ""}, {tolerances, ""}, story};
  for (const std::string& path : scan_paths) report.scan_files.push_back({path, ""});
  std::vector<ReportFile*> files{&report.model_file, &report.tolerances_file};
  for (ReportFile& file : report.scan_files) files.push_back(&file);
  for (ReportFile* file : files) {
    if (file->name.empty()) continue;
    Result<std::string> sha = sha256_of(file->name);
    if (!sha) return sha.error();
    file->sha256 = *sha;
  }
  console.begin_stage("writing the report");
  if (Status status = write_report(out, report); !status) return status.error();
  if (on_report)
    if (Status status = on_report(report); !status) return status.error();
  if (Status status = console.put_json(report_json(report)); !status) return status.error();
  const std::string page = (std::filesystem::path(out) / "report.html").string();
  console.print(terminal_text(report, page, wants_colour(STDOUT_FILENO)));
  return exit_code(inspection.inspection.verdict);
}

}  // namespace tetragauge::cli
