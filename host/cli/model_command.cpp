// SPDX-License-Identifier: GPL-3.0-or-later
#include <map>

#include "host/cli/check_outputs.hpp"
#include "host/cli/face_table.hpp"
#include "host/cli/input_options.hpp"
#include "host/geometry/face_list_file.hpp"

namespace tetragauge::cli {
namespace {

nlohmann::ordered_json model_json(const Solid& solid) {
  nlohmann::ordered_json json = face_list_to_json(solid.list, "tetragauge/model/1");
  const auto vec = [](const Vec3& v) {
    return nlohmann::ordered_json{v.x() + 0.0, v.y() + 0.0, v.z() + 0.0};
  };
  json["declared_unit"] = solid.declared_unit;
  json["solids"] = solid.solids;
  json["volume_mm3"] = solid.volume_mm3;
  json["area_mm2"] = solid.area_mm2;
  json["centroid_mm"] = vec(solid.centroid_mm);
  json["box_min_mm"] = vec(solid.box_min_mm);
  json["box_max_mm"] = vec(solid.box_max_mm);
  std::map<std::string, int> counts;
  for (const Face& face : solid.faces()) ++counts[std::string(surface_type_name(face.type))];
  json["count_by_type"] = counts;
  json["warnings"] = solid.warnings;
  return json;
}

std::string model_summary(const Solid& solid) {
  const Vec3 size = solid.box_max_mm - solid.box_min_mm;
  char line[300];
  std::snprintf(
      line, sizeof line, "%d solid%s, %zu faces, %.6g x %.6g x %.6g mm%s, volume %.6g mm3, area %.6g mm2\n",
      solid.solids, solid.solids == 1 ? "" : "s", solid.faces().size(), size.x(), size.y(), size.z(),
      solid.declared_unit.empty() ? "" : (" (file unit " + solid.declared_unit + ")").c_str(),
      solid.volume_mm3, solid.area_mm2);
  std::string text = line;
  std::map<std::string, int> counts;
  for (const Face& face : solid.faces()) ++counts[std::string(surface_type_name(face.type))];
  for (const auto& [type, count] : counts) text += "  " + type + " " + std::to_string(count);
  return text + "\n";
}

}  // namespace

void add_model(CLI::App& app, Console& console, Run& run) {
  auto options = std::make_shared<InputOptions>();
  CLI::App* command =
      add_command(app, console, "model", "A solid model's faces: type, equation, area, neighbours");
  command->add_option("model", options->model, "Solid model: .step .stp .csg")
      ->required()
      ->type_name("MODEL");
  options->add_unit(*command);
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = check_outputs(console, {}, {options->model}); !status) return status.error();
      Result<Solid> model = options->read_model(console);
      if (!model) return model.error();
      if (Status status = console.put_json(model_json(*model)); !status) return status.error();
      console.print(model_summary(*model) + face_table(model->list));
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
