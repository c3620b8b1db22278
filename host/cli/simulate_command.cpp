// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/check_outputs.hpp"
#include "host/cli/input_options.hpp"
#include "host/simulate/simulate.hpp"

namespace tetragauge::cli {

void add_simulate(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    SimulateOptions simulate;
    std::string pose, out;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "simulate", "Ray casting against a model: a scan without firmware");
  options->input.add_model(*command);
  options->input.add_unit(*command);
  command->add_option("--out", options->out, "Scan file to write")
      ->required()
      ->type_name("SCAN.ply")
      ->check(not_empty());
  command->add_option("--views", options->simulate.views, "View points around the part")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  auto* pitch =
      command->add_option("--pitch", options->simulate.pitch_mm, "Spacing of the rays at the part, mm")
          ->check(CLI::Range(1e-3, 1e3))
          ->capture_default_str();
  command->add_option("--points", options->simulate.points, "Points wanted: chooses the pitch")
      ->excludes(pitch);
  command->add_option("--sigma", options->simulate.sigma_mm, "Standard deviation along the ray, mm")
      ->check(CLI::Range(1e-6, 10.0))
      ->capture_default_str();
  command->add_option("--seed", options->simulate.seed, "Seed of the noise")->capture_default_str();
  command
      ->add_option("--pose", options->pose,
                   "Pose of the model in the scan: degrees and mm, p = t + Rz Ry Rx p_model")
      ->type_name("RX,RY,RZ,TX,TY,TZ");
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = check_outputs(console, {options->out}, {options->input.model}); !status)
        return status.error();
      if (!options->pose.empty()) {
        Result<RigidTransform> pose = parse_pose(options->pose, "--pose");
        if (!pose) return pose.error();
        options->simulate.T_scan_model = *pose;
      }
      Result<Solid> model = options->input.read_model(console);
      if (!model) return model.error();
      Result<Scan> scan = simulate(*model, RayCaster(*model), options->simulate);
      if (!scan) return scan.error();
      if (Status status = write_scan(options->out, *scan); !status) return status.error();
      const nlohmann::ordered_json result{{"schema", "tetragauge/simulate/1"},
                                          {"points", scan->size()},
                                          {"views", options->simulate.views},
                                          {"seed", options->simulate.seed}};
      if (Status status = console.put_json(result); !status) return status.error();
      console.say(options->out + ": " + std::to_string(scan->size()) + " points");
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
