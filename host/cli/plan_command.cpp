// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "host/base/whole_file.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/cli/input_options.hpp"
#include "host/cli/plan_options.hpp"
#include "host/plan/place_on_table.hpp"

namespace tetragauge::cli {
namespace {

std::string in_short(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string face_lines(const PartPlan& plan) {
  std::string text = "face   points  visible  flatter  incidence\n";
  for (const FaceOutlook& face : plan.faces) {
    char line[80];
    std::snprintf(line, sizeof line, "%4d %8zu %7.0f%% %7.0f%% ", face.id, face.points,
                  100 * face.visible_share, 100 * face.flat_share);
    text += line;
    text += face.is_seen ? in_short("%6.0f deg", face.least_incidence_deg) : "  " + face.why;
    text += "\n";
  }
  return text;
}

nlohmann::ordered_json forecast_json(const PartPlan& plan) {
  nlohmann::ordered_json faces = nlohmann::ordered_json::array();
  for (const FaceOutlook& face : plan.faces) {
    nlohmann::ordered_json entry{{"id", face.id},
                                 {"seen", face.is_seen},
                                 {"points", face.points},
                                 {"visible_share", face.visible_share},
                                 {"flat_share", face.flat_share}};
    if (face.obstacle == Obstacle::none) entry["least_incidence_deg"] = face.least_incidence_deg;
    if (!face.is_seen) entry["why"] = face.why;
    faces.push_back(entry);
  }
  return {{"schema", "tetragauge/plan/1"},
          {"views", plan.scan.views.size()},
          {"places", plan.places},
          {"predicted_s", plan.time_s},
          {"faces", faces}};
}

}  // namespace

void PlanArguments::add(CLI::App& command) {
  command.add_option("--points", options.points_per_face, "Points that every visible face gets at least")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      .add_option("--max-incidence", options.max_incidence_deg,
                  "Largest angle of beam and camera to a face's normal, degrees")
      ->check(CLI::Range(5.0, 84.0))
      ->capture_default_str();
  command.add_option("--samples", options.samples, "Samples of a point with the laser on; even")
      ->check(CLI::Range(2, 4096))
      ->capture_default_str();
}

Status PlanArguments::check() const {
  if (options.samples % 2 == 0) return Done{};
  return usage_error("--samples " + std::to_string(options.samples) +
                     ": must be even: half as many are taken before and after");
}

void add_plan(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    PlanArguments plan;
    std::string pose, place, out, port;
    int baud = TransportOptions{}.baud;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = add_command(
      app, console, "plan", "Views for a part of known pose: what each face gets, and which none can see");
  options->input.add_model(*command);
  options->input.add_unit(*command);
  auto* pose = command->add_option(
      "--pose", options->pose, "Pose of the model on the table: degrees and mm, p = t + Rz Ry Rx p_model");
  pose->type_name("RX,RY,RZ,TX,TY,TZ");
  command
      ->add_option(
          "--place", options->place,
          "How the part stands on the table: turned (degrees), then shifted (mm); as modelled unless given")
      ->type_name("RX,RY,RZ,TX,TY,TZ")
      ->excludes(pose);
  options->plan.add(*command);
  command
      ->add_option("--pitch", options->plan.options.pitch_mm,
                   "Spacing of the beams, mm; finer where a face needs it")
      ->check(CLI::Range(0.1, 20.0))
      ->capture_default_str();
  auto* port =
      command
          ->add_option(
              "--port", options->port,
              "Plan for this machine (/dev/ttyX, unix:PATH, tcp:HOST:PORT); the nominal one unless given")
          ->type_name("DEV");
  command->add_option("--baud", options->baud, kBaudHelp)
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(port);
  command->add_option("--out", options->out, "Plan to write (JSON)")
      ->required()
      ->type_name("PLAN.json")
      ->check(not_empty());
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = options->plan.check(); !status) return status.error();
      if (Status status = check_outputs(console, {options->out}, {options->input.model}); !status)
        return status.error();
      RigidTransform given;
      for (const auto& [text, option] :
           {std::pair(options->pose, "--pose"), std::pair(options->place, "--place")}) {
        if (text.empty()) continue;
        Result<RigidTransform> read = parse_pose(text, option);
        if (!read) return read.error();
        given = *read;
      }
      Result<Solid> model = options->input.read_model(console);
      if (!model) return model.error();
      PlanningMachine machine = nominal_machine();
      if (!options->port.empty()) {
        MachineArguments at;
        at.port = options->port;
        at.baud = options->baud;
        if (Status status = at.check(); !status) return status.error();
        Result<OpenMachine> opened = at.open();
        if (!opened) return opened.error();
        Result<PlanningMachine> read = read_machine(*opened->link);
        if (!read) return read.error();
        machine = *read;
      }
      const RigidTransform T_part_model = options->pose.empty() ? place_on_table(*model, given) : given;
      Result<PartPlan> plan =
          plan_part(machine, *model, RayCaster(*model), T_part_model, options->plan.options);
      if (!plan) return plan.error();
      if (Status status = write_whole_file(options->out, plan_json(plan->scan)); !status)
        return status.error();
      if (Status status = console.put_json(forecast_json(*plan)); !status) return status.error();
      console.print(face_lines(*plan) + plan_sentence(*plan) + "\n");
      console.say("plan: " + options->out);
      return 0;
    };
  });
}

std::string plan_sentence(const PartPlan& plan) {
  const auto unseen = std::count_if(plan.faces.begin(), plan.faces.end(),
                                    [](const FaceOutlook& face) { return !face.is_seen; });
  return std::to_string(plan.scan.views.size()) + (plan.scan.views.size() == 1 ? " view" : " views") +
         " from " + std::to_string(plan.places) + (plan.places == 1 ? " place" : " places") +
         in_short(" of the stage, %.0f s predicted; ", plan.time_s) + std::to_string(unseen) + " of " +
         std::to_string(plan.faces.size()) + " faces cannot be seen";
}

}  // namespace tetragauge::cli
