// SPDX-License-Identifier: GPL-3.0-or-later
#include <map>

#include "host/cli/check_outputs.hpp"
#include "host/cli/face_table.hpp"
#include "host/cli/input_options.hpp"
#include "host/geometry/face_list_file.hpp"
#include "host/solid/face_loops.hpp"

namespace tetragauge::cli {
namespace {

std::map<std::string, int> count_by_type(const FaceList& list) {
  std::map<std::string, int> counts;
  for (const Face& face : list.faces) ++counts[std::string(surface_type_name(face.type))];
  return counts;
}

std::string type_line(const FaceList& list) {
  std::string text;
  for (const auto& [type, count] : count_by_type(list)) text += "  " + type + " " + std::to_string(count);
  return text + "\n";
}

nlohmann::ordered_json vec(const Vec3& v) {
  return {v.x() + 0.0, v.y() + 0.0, v.z() + 0.0};  // no minus zero
}

nlohmann::ordered_json edge_json(const LoopEdge& edge) {
  nlohmann::ordered_json json{{"corner_mm", vec(edge.corner_mm)}, {"beyond", edge.beyond}};
  json["curve"] = edge.is_line ? "line" : edge.circle ? "circle" : "other";
  if (edge.circle) {
    json["centre_mm"] = vec(edge.circle->centre_mm);
    json["axis"] = vec(edge.circle->axis);
    json["radius_mm"] = edge.circle->radius_mm;
  }
  if (edge.is_line) return json;
  nlohmann::ordered_json& points = json["points_mm"] = nlohmann::ordered_json::array();
  for (const Vec3& p : edge.points_mm) points.push_back(vec(p));
  return json;
}

nlohmann::ordered_json model_json(const Solid& solid) {
  nlohmann::ordered_json json = face_list_to_json(solid.list, "tetragauge/model/1");
  const std::vector<std::vector<FaceLoop>> loops = face_loops(solid);
  for (size_t i = 0; i < loops.size(); ++i) {
    nlohmann::ordered_json& boundary = json["faces"][i]["boundary"] = nlohmann::ordered_json::array();
    for (const FaceLoop& loop : loops[i]) {
      nlohmann::ordered_json& edges = boundary.emplace_back(nlohmann::ordered_json::array());
      for (const LoopEdge& edge : loop) edges.push_back(edge_json(edge));
    }
  }
  json["declared_unit"] = solid.declared_unit;
  json["solids"] = solid.solids;
  json["volume_mm3"] = solid.volume_mm3;
  json["area_mm2"] = solid.area_mm2;
  json["centroid_mm"] = vec(solid.centroid_mm);
  json["box_min_mm"] = vec(solid.box_min_mm);
  json["box_max_mm"] = vec(solid.box_max_mm);
  json["count_by_type"] = count_by_type(solid.list);
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
  return line + type_line(solid.list);
}

// A list has planes and areas, and nothing else of a solid.
Result<int> list_planes(const InputOptions& options, const Console& console) {
  const Result<double> unit = options.model_unit_mm();
  if (!unit) return unit.error();
  Result<FaceList> list = read_face_list(options.model, *unit);
  if (!list) return list.error();
  nlohmann::ordered_json json = face_list_to_json(*list, "tetragauge/model/1");
  double area = 0;
  for (const Face& face : list->faces) area += face.area_mm2;
  json["area_mm2"] = area;
  json["count_by_type"] = count_by_type(*list);
  json["warnings"] = nlohmann::ordered_json::array();
  if (Status status = console.put_json(json); !status) return status.error();
  console.print("list of " + std::to_string(list->faces.size()) + " planes, no solid\n" + type_line(*list) +
                face_table(*list));
  return 0;
}

}  // namespace

void add_model(CLI::App& app, Console& console, Run& run) {
  auto options = std::make_shared<InputOptions>();
  CLI::App* command =
      add_command(app, console, "model", "A solid model's faces: type, equation, area, neighbours");
  command
      ->add_option("model", options->model,
                   std::string("Solid model (") + kModelFiles + "), or a list of planes (.hsp)")
      ->required()
      ->type_name("MODEL");
  options->add_facets(*command);
  options->add_unit(*command);
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = check_outputs(console, {}, {options->model}); !status) return status.error();
      if (options->model.ends_with(".hsp")) return list_planes(*options, console);
      Result<Solid> model = options->read_model(console);
      if (!model) return model.error();
      if (Status status = console.put_json(model_json(*model)); !status) return status.error();
      console.print(model_summary(*model) + face_table(model->list));
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
