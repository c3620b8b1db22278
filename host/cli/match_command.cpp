// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/check_outputs.hpp"
#include "host/cli/input_options.hpp"
#include "host/geometry/face_list_file.hpp"
#include "host/match/match.hpp"
#include "host/report/report.hpp"

namespace tetragauge::cli {
namespace {

std::string match_text(const Match& match) {
  std::string text;
  char line[200];
  const Vec3 deg = degrees_from_rotation(match.T_model_part.R);
  const Vec3& t = match.T_model_part.t;
  std::snprintf(
      line, sizeof line,
      "pose (model from part): Rz(%.4f) Ry(%.4f) Rx(%.4f) degrees, t = %.4f %.4f %.4f mm, rms %.4f mm\n",
      deg.z(), deg.y(), deg.x(), t.x(), t.y(), t.z(), match.rms_mm);
  text += line;
  text += "model measured   offset mm  angle mrad\n";
  for (const FacePair& pair : match.pairs) {
    std::snprintf(line, sizeof line, "%5d %8d %11.4f %11.3f\n", pair.model, pair.measured, pair.offset_mm,
                  1e3 * pair.angle_rad);
    text += line;
  }
  const auto list = [&](const char* what, const std::vector<int>& ids) {
    if (ids.empty()) return;
    text += what;
    for (const int id : ids) text += " " + std::to_string(id);
    text += "\n";
  };
  list("model faces without a measured one:", match.unmatched_model);
  list("measured faces without a model one:", match.unmatched_measured);
  if (!match.equivalents.empty()) {
    text += std::to_string(match.equivalents.size()) +
            " more poses that the data cannot tell apart, the first: " + match.equivalents.front().why + "\n";
  }
  for (const FreeDirection& free : match.undetermined) {
    std::snprintf(line, sizeof line, "undetermined: %s along %.4f %.4f %.4f\n",
                  free.kind == FreeDirection::Kind::translation ? "translation" : "rotation", free.axis.x(),
                  free.axis.y(), free.axis.z());
    text += line;
  }
  return text;
}

}  // namespace

void add_match(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    std::string measured;
    MatchOptions match;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "match", "Measured faces against a model's, with no initial pose");
  command
      ->add_option("--model", options->input.model,
                   std::string("Solid model (") + kModelFiles + ") or a list (.hsp .json)")
      ->required()
      ->type_name("MODEL");
  options->input.add_facets(*command);
  command->add_option("--measured", options->measured, "Faces as `faces --json` writes them, or a list .hsp")
      ->required()
      ->type_name("FACES");
  command->add_flag("--unsigned", options->match.is_unsigned, "Normals do not tell the side of the material");
  options->input.add_unit(*command);
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      const std::string& name = options->input.model;
      if (Status status = check_outputs(console, {}, {name, options->measured}); !status)
        return status.error();
      Result<double> model_unit = options->input.model_unit_mm();
      if (!model_unit) return model_unit.error();
      FaceList model;
      if (name.ends_with(".hsp") || name.ends_with(".json")) {
        Result<FaceList> list = read_face_list(name, *model_unit);
        if (!list) return list.error();
        model = std::move(*list);
      } else {
        Result<Solid> solid = options->input.read_model(console);
        if (!solid) return solid.error();
        model = std::move(solid->list);
      }
      Result<double> unit = options->input.unit.empty() ? Result<double>(1.0) : unit_mm(options->input.unit);
      if (!unit) return unit.error();
      Result<FaceList> measured = read_face_list(options->measured, *unit);
      if (!measured) return measured.error();
      Result<Match> match = match_face_lists(model, *measured, options->match);
      if (!match) return match.error();
      if (Status status = console.put_json(match_json(*match, "search")); !status) return status.error();
      console.print(match_text(*match));
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
