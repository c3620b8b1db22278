// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/check_outputs.hpp"
#include "host/cli/face_table.hpp"
#include "host/cli/input_options.hpp"
#include "host/faces/find_faces.hpp"
#include "host/geometry/face_list_file.hpp"

namespace tetragauge::cli {

void add_faces(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "faces", "The real faces of the part, each fitted to all its points");
  options->input.add_scan(*command);
  options->input.add_unit(*command);
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = check_outputs(console, {}, {options->input.scan}); !status) return status.error();
      Result<Scan> scan = options->input.read_scan(console);
      if (!scan) return scan.error();
      Result<Reconstruction> reconstruction = reconstruct(*scan);
      if (!reconstruction) return reconstruction.error();
      Result<MeasuredFaces> faces = find_faces(*scan, *reconstruction);
      if (!faces) return faces.error();
      if (Status status = console.put_json(face_list_to_json(faces->list, "tetragauge/faces/1")); !status)
        return status.error();
      console.print(face_table(faces->list));
      console.say(std::to_string(faces->points_used) + " points on " + std::to_string(faces->faces().size()) +
                  " faces, " + std::to_string(faces->points_rejected) + " on none");
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
