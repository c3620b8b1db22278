// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/inspect_options.hpp"

#include <unistd.h>

#include "host/base/whole_file.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/report/report.hpp"

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
  command.add_option("--out", out, "Folder for report.json, report.txt, deviation.ply")
      ->required()
      ->type_name("DIR")
      ->check(not_empty());
  using Rule = InspectOptions::Rule;
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
  for (const char* name : {"report.json", "report.txt", "deviation.ply"})
    outputs.push_back((std::filesystem::path(out) / name).string());
  for (const std::string& name : more_files) outputs.push_back((std::filesystem::path(out) / name).string());
  inputs.push_back(tolerances);
  return check_outputs(console, outputs, inputs);
}

Result<Tolerances> InspectArguments::read_limits(const Solid& model) const {
  if (tolerances.empty()) return Tolerances{};
  return read_tolerances(tolerances, model.list);
}

Result<int> InspectArguments::run(const Console& console, const Scan& scan, const std::string& scan_path,
                                  const Solid& model, const std::string& model_path,
                                  const Tolerances& limits) const {
  Result<InspectionRun> inspection = tetragauge::inspect(scan, model, limits, inspect);
  if (!inspection) return inspection.error();
  ReportInput input;
  input.scan_name = scan_path;
  input.model_name = model_path;
  input.tolerances_name = tolerances;
  for (auto [name, hash] :
       {std::pair{&input.scan_name, &input.scan_sha256}, std::pair{&input.model_name, &input.model_sha256},
        std::pair{&input.tolerances_name, &input.tolerances_sha256}}) {
    if (name->empty()) continue;
    Result<std::string> sha = sha256_of(*name);
    if (!sha) return sha.error();
    *hash = *sha;
  }
  if (Status status = write_report(out, *inspection, scan, model, limits, input); !status)
    return status.error();
  if (Status status = console.put_json(report_json(*inspection, scan, model, limits, input)); !status)
    return status.error();
  console.print(report_text(*inspection, scan, model, limits, input));
  console.say("report: " + (std::filesystem::path(out) / "report.txt").string());
  return exit_code(inspection->inspection.verdict);
}

}  // namespace tetragauge::cli
