// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/whole_file.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/cli/input_options.hpp"
#include "host/reconstruct/mesh_file.hpp"
#include "host/report/report.hpp"

namespace tetragauge::cli {

void add_reconstruct(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    ReconstructOptions reconstruct;
    std::string out;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "reconstruct", "The surface between solid and air, from points with rays");
  options->input.add_scan(*command);
  options->input.add_unit(*command);
  command->add_option("--out", options->out, "Mesh to write")
      ->required()
      ->type_name("MESH.ply")
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
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = check_outputs(console, {options->out}, {options->input.scan}); !status)
        return status.error();
      Result<Scan> scan = options->input.read_scan(console);
      if (!scan) return scan.error();
      Result<Reconstruction> reconstruction = reconstruct(*scan, options->reconstruct);
      if (!reconstruction) return reconstruction.error();
      if (Status status = write_whole_file(options->out, surface_to_ply(*reconstruction)); !status)
        return status.error();
      if (Status status = console.put_json(reconstruction_json(*scan, *reconstruction)); !status)
        return status.error();
      char text[300];
      std::snprintf(text, sizeof text,
                    "%zu tetrahedra: %zu air, %zu solid, %zu doubtful; %zu triangles, %s\nvolume %.1f mm3, "
                    "seen area %.1f mm2\n",
                    reconstruction->tetrahedra, reconstruction->air, reconstruction->solid,
                    reconstruction->doubtful, reconstruction->surface.size(),
                    reconstruction->closed ? "closed" : "not closed", reconstruction->volume_mm3,
                    reconstruction->area_mm2);
      console.print(text);
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
