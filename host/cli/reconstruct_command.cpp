// SPDX-License-Identifier: GPL-3.0-or-later
#include <cctype>
#include <filesystem>
#include <optional>

#include "host/base/whole_file.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/cli/input_options.hpp"
#include "host/reconstruct/mesh_file.hpp"
#include "host/reconstruct/resting_positions.hpp"
#include "host/report/json_values.hpp"
#include "host/report/report.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge::cli {
namespace {

using nlohmann::ordered_json;

// As many as a person or a planner looks at; `doubtful` has the count of all.
constexpr size_t kRankedInJson = 100;

ordered_json doubtful_json(const Reconstruction& reconstruction) {
  ordered_json list = ordered_json::array();
  for (const DoubtfulTetrahedron& d : reconstruction.doubtful_ranked) {
    if (list.size() == kRankedInJson) break;
    list.push_back({{"label", d.is_air ? "air" : "solid"},
                    {"confidence", json_number(static_cast<double>(d.confidence))},
                    {"centroid_mm", json_matrix(d.centroid_mm)},
                    {"volume_mm3", json_number(d.volume_mm3)},
                    {"face_area_mm2", json_number(d.face_area_mm2)},
                    {"look_from", json_matrix(d.look_from)}});
  }
  return list;
}

ordered_json resting_json(const std::vector<RestingPosition>& positions) {
  ordered_json list = ordered_json::array();
  for (const RestingPosition& p : positions) {
    ordered_json contact = ordered_json::array();
    for (const Vec3& c : p.contact_mm) contact.push_back(json_matrix(c));
    list.push_back({{"down", json_matrix(p.down)},
                    {"d_mm", json_number(p.d_mm)},
                    {"height_mm", json_number(p.height_mm)},
                    {"margin_mm", json_number(p.margin_mm)},
                    {"tipping_rad", json_number(p.tipping_rad)},
                    {"contact_mm", std::move(contact)}});
  }
  return list;
}

std::string lower_case_ending(const std::string& name) {
  std::string ending = std::filesystem::path(name).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

}  // namespace

void add_reconstruct(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    ReconstructOptions reconstruct;
    std::string out, tetrahedra;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "reconstruct", "The surface between solid and air, from points with rays");
  options->input.add_scan(*command);
  command
      ->add_option("--model", options->input.model,
                   "Model in the scan's frame: --method carve shoots its last rays into it")
      ->type_name("MODEL")
      ->check(not_empty());
  options->input.add_unit(*command);
  command->add_option("--out", options->out, "Mesh to write; ends in .ply or .stl")
      ->required()
      ->type_name("MESH.ply|MESH.stl")
      ->check(not_empty());
  command
      ->add_option("--method", options->reconstruct.method,
                   "cut: soft visibility and minimum cut; carve: one ray makes air")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, ReconstructMethod>{
                                      {"cut", ReconstructMethod::cut}, {"carve", ReconstructMethod::carve}})
              .description(""))
      ->type_name("METHOD")
      ->default_str("cut");
  command
      ->add_option("--spacing", options->reconstruct.spacing_mm,
                   "Spacing of the averaged vertices, mm (0: from the data)")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--export-tetrahedra", options->tetrahedra,
                   "All tetrahedra with label and votes, for ParaView")
      ->type_name("FILE.vtu")
      ->check(not_empty());
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      std::vector<std::string> outputs{options->out};
      if (!options->tetrahedra.empty()) outputs.push_back(options->tetrahedra);
      if (Status status = check_outputs(console, outputs, {options->input.scan, options->input.model});
          !status)
        return status.error();
      const std::string ending = lower_case_ending(options->out);
      if (ending != ".ply" && ending != ".stl")
        return usage_error("--out " + options->out + ": the name must end in .ply or .stl");
      ReconstructOptions reconstruct_options = options->reconstruct;
      reconstruct_options.keep_tetrahedra = !options->tetrahedra.empty();
      std::optional<RayCaster> model;
      if (!options->input.model.empty()) {
        if (reconstruct_options.method != ReconstructMethod::carve)
          return usage_error("--model goes with --method carve; leave it out, or choose that method");
        Result<Solid> solid = options->input.read_model(console);
        if (!solid) return solid.error();
        model.emplace(*solid);
        reconstruct_options.model = &*model;
      }
      Result<Scan> scan = options->input.read_scan(console);
      if (!scan) return scan.error();
      Result<Reconstruction> reconstruction = reconstruct(*scan, reconstruct_options);
      if (!reconstruction) return reconstruction.error();
      const std::string mesh =
          ending == ".stl" ? surface_to_stl(*reconstruction) : surface_to_ply(*reconstruction);
      if (Status status = write_whole_file(options->out, mesh); !status) return status.error();
      if (!options->tetrahedra.empty()) {
        if (Status status = write_whole_file(options->tetrahedra, tetrahedra_to_vtu(*reconstruction));
            !status)
          return status.error();
      }
      const std::vector<RestingPosition> resting = resting_positions(*reconstruction);
      ordered_json json = reconstruction_json(*scan, *reconstruction);
      json["doubtful_ranked"] = doubtful_json(*reconstruction);
      json["resting_positions"] = resting_json(resting);
      if (Status status = console.put_json(json); !status) return status.error();
      char text[300];
      std::snprintf(text, sizeof text,
                    "%zu tetrahedra: %zu air, %zu solid, %zu doubtful; %zu triangles, %s\nvolume %.1f mm3, "
                    "seen area %.1f mm2; %zu resting positions\n",
                    reconstruction->tetrahedra, reconstruction->air, reconstruction->solid,
                    reconstruction->doubtful, reconstruction->surface.size(),
                    reconstruction->closed ? "closed" : "not closed", reconstruction->volume_mm3,
                    reconstruction->area_mm2, resting.size());
      console.print(text);
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
