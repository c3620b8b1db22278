// SPDX-License-Identifier: GPL-3.0-or-later
#include <numbers>

#include "host/cli/check_outputs.hpp"
#include "host/cli/input_options.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/simulate/simulate.hpp"

namespace tetragauge::cli {
namespace {

// "A,B" and "N,M".
Result<BeamWindow> parse_window(std::string_view angles, std::string_view rays) {
  BeamWindow window;
  std::string_view rest_of_angles = angles, rest_of_rays = rays;
  for (size_t axis = 0; axis < 2; ++axis) {
    const auto angle_deg = parse_number<double>(next_word(rest_of_angles));
    if (!angle_deg)
      return usage_error("--window " + std::string(angles) + ": expected two angles A,B in degrees");
    const auto count = parse_number<int>(next_word(rest_of_rays));
    if (!count) return usage_error("--rays " + std::string(rays) + ": expected two numbers N,M");
    window.angle_rad[axis] = *angle_deg * std::numbers::pi / 180;
    window.rays[axis] = *count;
  }
  if (!next_word(rest_of_angles).empty())
    return usage_error("--window " + std::string(angles) + ": expected two angles A,B in degrees");
  if (!next_word(rest_of_rays).empty())
    return usage_error("--rays " + std::string(rays) + ": expected two numbers N,M");
  return window;
}

// "uniform:LO:HI", mm.
Result<UniformPerturbation> parse_perturbation(const std::string& text) {
  const Error error =
      usage_error("--perturb " + text + ": expected uniform:LO:HI in mm, e.g. uniform:0.01:0.1");
  constexpr std::string_view kind = "uniform:";
  if (!text.starts_with(kind)) return error;
  const std::string_view numbers = std::string_view(text).substr(kind.size());
  const size_t colon = numbers.find(':');
  if (colon == std::string_view::npos) return error;
  const auto low = parse_number<double>(numbers.substr(0, colon)),
             high = parse_number<double>(numbers.substr(colon + 1));
  if (!low || !high || !(*low < *high)) return error;
  return UniformPerturbation{*low, *high};
}

}  // namespace

void add_simulate(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    SimulateOptions simulate;
    std::string pose, out, window, rays, perturbation;
    std::vector<std::string> view_points;
    double max_incidence_deg = 80;
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
  auto* views =
      command
          ->add_option(
              "--views", options->simulate.views,
              "View points around the part: 6 on the axes, 8 over the corners, 14 both, or any number")
          ->check(CLI::Range(1, 1000))
          ->capture_default_str();
  command
      ->add_option("--view", options->view_points,
                   "A view point of the scan frame, mm; may be given several times")
      ->type_name("X,Y,Z")
      ->excludes(views);
  auto* pitch =
      command->add_option("--pitch", options->simulate.pitch_mm, "Spacing of the rays at the part, mm")
          ->check(CLI::Range(1e-3, 1e3))
          ->capture_default_str();
  auto* points =
      command->add_option("--points", options->simulate.points, "Points wanted: chooses the pitch");
  points->excludes(pitch);
  auto* window = command->add_option("--window", options->window,
                                     "Angles across and up that the rays of a view fill, degrees");
  window->type_name("A,B")->excludes(pitch)->excludes(points);
  auto* rays = command->add_option("--rays", options->rays, "Rays across and up in the window");
  rays->type_name("N,M")->needs(window);
  window->needs(rays);
  auto* sigma =
      command->add_option("--sigma", options->simulate.sigma_mm, "Standard deviation along the ray, mm");
  sigma->check(CLI::Range(1e-6, 10.0))->capture_default_str();
  command
      ->add_option("--perturb", options->perturbation,
                   "Instead of --sigma: evenly spread from LO to HI mm along the ray, either way if LO is "
                   "not negative")
      ->type_name("uniform:LO:HI")
      ->excludes(sigma);
  command
      ->add_option("--max-incidence", options->max_incidence_deg,
                   "A ray that meets the face at a larger angle to its normal gives no point, degrees")
      ->check(CLI::Range(1.0, 90.0))
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
      for (const std::string& text : options->view_points) {
        Result<Vec3> point = parse_vec3(text, "--view");
        if (!point) return point.error();
        options->simulate.view_points_mm.push_back(*point);
      }
      if (!options->window.empty()) {
        Result<BeamWindow> window = parse_window(options->window, options->rays);
        if (!window) return window.error();
        options->simulate.window = *window;
      }
      if (!options->perturbation.empty()) {
        Result<UniformPerturbation> perturbation = parse_perturbation(options->perturbation);
        if (!perturbation) return perturbation.error();
        options->simulate.perturbation = *perturbation;
      }
      options->simulate.max_incidence_rad = options->max_incidence_deg * std::numbers::pi / 180;
      Result<Solid> model = options->input.read_model(console);
      if (!model) return model.error();
      Result<Scan> scan = simulate(*model, RayCaster(*model), options->simulate);
      if (!scan) return scan.error();
      if (Status status = write_scan(options->out, *scan); !status) return status.error();
      const nlohmann::ordered_json result{
          {"schema", "tetragauge/simulate/1"},
          {"points", scan->size()},
          {"views", options->simulate.view_points_mm.empty() ? static_cast<size_t>(options->simulate.views)
                                                             : options->simulate.view_points_mm.size()},
          {"seed", options->simulate.seed}};
      if (Status status = console.put_json(result); !status) return status.error();
      console.say(options->out + ": " + std::to_string(scan->size()) + " points");
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
