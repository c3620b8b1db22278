// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/input_options.hpp"

#include "host/geometry/face_list_file.hpp"
#include "host/geometry/parse_number.hpp"

namespace tetragauge::cli {

const char* const kModelFiles = ".step .stp .csg .stl .obj .ply .off";

void InputOptions::add_scan(CLI::App& command) {
  command.add_option("scan", scan, "Scan: .ply with rays, or a cloud (.ply .pcd .xyz .csv)")
      ->required()
      ->type_name("SCAN");
  complete_scan(command);
}

void InputOptions::add_scans(CLI::App& command, std::vector<std::string>& scans) {
  command
      .add_option(
          "scan", scans,
          "Scans: .ply with rays, or clouds (.ply .pcd .xyz .csv); several of one part, turned over between "
          "them, are judged together")
      ->required()
      ->type_name("SCAN");
  complete_scan(command);
}

void InputOptions::complete_scan(CLI::App& command) {
  command
      .add_option("--ray-origin", ray_origin,
                  "Clouds without rays: where the sensor stood, in the scan's unit")
      ->type_name("X,Y,Z");
  command
      .add_option("--ray-direction", ray_direction,
                  "Clouds without rays: the way the light travelled (parallel rays)")
      ->type_name("X,Y,Z");
  command.add_option("--sigma", sigma_mm, "Clouds without sigma: standard deviation along the ray, mm")
      ->check(CLI::PositiveNumber);
}

void InputOptions::add_model(CLI::App& command) {
  command.add_option("--model", model, std::string("Solid model: ") + kModelFiles)
      ->required()
      ->type_name("MODEL");
  add_facets(command);
}

void InputOptions::add_facets(CLI::App& command) {
  command.add_flag("--facets", keep_facets,
                   ".csg: keep all facets of round bodies; meshes: every plane facet is a face of its own");
}

void InputOptions::add_unit(CLI::App& command) {
  const std::string units = "mm, cm, m, um or inch";
  command.add_option("--unit", unit, "Unit of files that state none: " + units);
  if (command.get_option_no_throw("scan"))
    command.add_option("--scan-unit", scan_unit, "Unit of the scan alone");
  if (command.get_option_no_throw("--model"))
    command.add_option("--model-unit", model_unit, "Unit of the model alone");
}

Result<Scan> InputOptions::read_scan(const Console& console, const std::string& path) const {
  ReadScanOptions options;
  const std::string& said = scan_unit.empty() ? unit : scan_unit;
  if (!said.empty()) {
    Result<double> scale = unit_mm(said);
    if (!scale) return scale.error();
    options.unit_scale_mm = *scale;
  }
  if (!ray_origin.empty()) {
    Result<Vec3> origin = parse_vec3(ray_origin, "--ray-origin");
    if (!origin) return origin.error();
    options.ray_origin_mm = *origin * options.unit_scale_mm.value_or(1.0);
  }
  if (!ray_direction.empty()) {
    Result<Vec3> direction = parse_vec3(ray_direction, "--ray-direction");
    if (!direction) return direction.error();
    if (!(direction->norm() > 1e-9))
      return usage_error("--ray-direction " + ray_direction + ": has no direction");
    options.ray_direction = *direction;
  }
  if (sigma_mm > 0) options.sigma_mm = sigma_mm;
  console.begin_stage("reading " + path);
  Result<Scan> read = tetragauge::read_scan(path, options);
  if (read) console.say(path + ": " + std::to_string(read->size()) + " points");
  return read;
}

Result<double> InputOptions::model_unit_mm() const {
  const std::string& said = model_unit.empty() ? unit : model_unit;
  return said.empty() ? Result<double>(1.0) : unit_mm(said);
}

Result<Solid> InputOptions::read_model(const Console& console) const {
  ReadSolidOptions options;
  options.keep_facets = keep_facets;
  if (!unit.empty() || !model_unit.empty()) {
    Result<double> scale = model_unit_mm();
    if (!scale) return scale.error();
    options.unit_scale_mm = *scale;
  }
  console.begin_stage("reading " + model);
  Result<Solid> read = read_solid(model, options);
  if (read) {
    for (const std::string& warning : read->warnings) console.say("warning: " + warning);
  }
  return read;
}

Result<Vec3> parse_vec3(const std::string& text, const std::string& option) {
  std::string_view rest = text;
  Vec3 v;
  for (int k = 0; k < 3; ++k) {
    const auto number = parse_number<double>(next_word(rest));
    if (!number) return usage_error(option + " " + text + ": expected three numbers X,Y,Z");
    v[k] = *number;
  }
  if (!next_word(rest).empty()) return usage_error(option + " " + text + ": expected three numbers X,Y,Z");
  return v;
}

}  // namespace tetragauge::cli
