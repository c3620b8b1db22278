// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/simulate/simulate.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <tuple>

#include "host/simulate/counter_noise.hpp"

namespace tetragauge {
namespace {

// More beams than this is a pitch too fine for the part, or a part in the wrong unit, not a scan: its file
// would have hundreds of megabytes, and memory several times that.
constexpr double kMostBeams = 2e7;

// REJECT_WEAK of protocol/machine.proto: too little light came back.
constexpr uint32_t kTooLittleLight = 1;

constexpr double kStandoffRadii = 4;

// One view: beams from one point through a raster, in the scan frame. Either a square raster on the plane
// across the view through the middle of the part, or a window evenly spread in angle.
struct View {
  Vec3 sensor, forward, u, v;
  double distance_mm = 0;                  // sensor to the middle of the part
  double pitch_mm = 0, reach_mm = 0;       // of the square raster; pitch 0: a window
  std::array<double, 2> half_angle_rad{};  // of the window
  int64_t rows = 0, columns = 0;

  Vec3 direction(int64_t row, int64_t column) const {
    return (forward + slope(column, columns, 0) * u + slope(row, rows, 1) * v).normalized();
  }
  bool is_in_reach(int64_t row, int64_t column) const {
    return pitch_mm == 0 ||
           std::hypot(coordinate(column, columns), coordinate(row, rows)) <= reach_mm + pitch_mm;
  }

 private:
  // The raster's middle lies between beams.
  double coordinate(int64_t i, int64_t count) const {
    return pitch_mm * (static_cast<double>(i) - 0.5 * static_cast<double>(count - 1));
  }
  double slope(int64_t i, int64_t count, size_t axis) const {
    if (pitch_mm > 0) return coordinate(i, count) / distance_mm;
    if (count < 2) return 0;
    return std::tan(half_angle_rad[axis] * (2 * static_cast<double>(i) / static_cast<double>(count - 1) - 1));
  }
};

struct Part {
  Vec3 middle = Vec3::Zero();  // scan frame
  double radius_mm = 0;
};

Part part_of(const Solid& solid, const RigidTransform& T_scan_model) {
  return {T_scan_model * Vec3(0.5 * (solid.box_min_mm + solid.box_max_mm)),
          0.5 * (solid.box_max_mm - solid.box_min_mm).norm()};
}

double standoff_of(const Part& part, const SimulateOptions& options) {
  return options.standoff_mm > 0 ? options.standoff_mm : kStandoffRadii * part.radius_mm;
}

// The cone from the sensor that touches the part's sphere, where it cuts the plane through the middle.
double reach_of(const Part& part, double standoff_mm) {
  return part.radius_mm * standoff_mm /
         std::sqrt(standoff_mm * standoff_mm - part.radius_mm * part.radius_mm);
}

std::vector<Vec3> sensors_of(const Part& part, const SimulateOptions& options) {
  if (!options.view_points_mm.empty()) return options.view_points_mm;
  std::vector<Vec3> sensors;
  for (const Vec3& direction : view_directions(options.views)) {
    sensors.push_back(part.middle + standoff_of(part, options) * direction);
  }
  return sensors;
}

std::vector<View> make_views(const Part& part, const SimulateOptions& options, double pitch_mm) {
  std::vector<View> views;
  for (const Vec3& sensor : sensors_of(part, options)) {
    View& view = views.emplace_back();
    view.sensor = sensor;
    view.distance_mm = (sensor - part.middle).norm();
    const Vec3 back = (sensor - part.middle) / view.distance_mm;
    view.forward = -back;
    std::tie(view.u, view.v) = tangent_frame(back);
    if (options.window) {
      for (size_t axis = 0; axis < 2; ++axis) view.half_angle_rad[axis] = options.window->angle_rad[axis] / 2;
      view.columns = options.window->rays[0];
      view.rows = options.window->rays[1];
      continue;
    }
    view.pitch_mm = pitch_mm;
    view.reach_mm = reach_of(part, view.distance_mm);
    view.rows = view.columns = 2 * static_cast<int64_t>(std::ceil(view.reach_mm / pitch_mm)) + 2;
  }
  return views;
}

struct Shot {
  Vec3 direction = Vec3::Zero();  // scan frame
  double distance_mm = 0;         // of the point, perturbed
  double cosine = 0;              // of the incidence; 0: no point
};

double perturbation_mm(const SimulateOptions& options, uint32_t view, uint64_t ray) {
  if (!options.perturbation) return options.sigma_mm * counter_normal(options.seed, view, ray);
  const auto [low, high] = *options.perturbation;
  const double length = low + (high - low) * counter_uniform(options.seed, view, ray, 0);
  return low >= 0 && counter_uniform(options.seed, view, ray, 1) < 0.5 ? -length : length;
}

// Root mean square of the perturbation: what a user of the scan may expect of a point.
double sigma_of(const SimulateOptions& options) {
  if (!options.perturbation) return options.sigma_mm;
  const auto [low, high] = *options.perturbation;
  return std::sqrt((low * low + low * high + high * high) / 3);
}

std::vector<Shot> shoot_row(const View& view, uint32_t number, int64_t row, const RayCaster& caster,
                            const SimulateOptions& options) {
  const RigidTransform T_model_scan = options.T_scan_model.inverse();
  const Vec3 origin = T_model_scan * view.sensor;
  const double least_cosine = std::cos(options.max_incidence_rad);
  std::vector<Shot> shots;
  for (int64_t column = 0; column < view.columns; ++column) {
    if (!view.is_in_reach(row, column)) continue;
    Shot shot;
    shot.direction = view.direction(row, column);
    const Vec3 direction = T_model_scan.R * shot.direction;
    const auto hit = caster.first_hit(origin, direction);
    if (hit && -hit->normal.dot(direction) >= least_cosine) {
      const uint64_t ray =
          static_cast<uint64_t>(row) * static_cast<uint64_t>(view.columns) + static_cast<uint64_t>(column);
      shot.distance_mm = hit->distance_mm + perturbation_mm(options, number, ray);
      shot.cosine = -hit->normal.dot(direction);
    }
    if (shot.cosine > 0 || options.keep_rejected) shots.push_back(shot);
  }
  return shots;
}

std::vector<std::vector<Shot>> shoot_view(const View& view, uint32_t number, const RayCaster& caster,
                                          const SimulateOptions& options) {
  std::vector<std::vector<Shot>> rows(static_cast<size_t>(view.rows));
  tbb::parallel_for(size_t{0}, rows.size(), [&](size_t row) {
    rows[row] = shoot_row(view, number, static_cast<int64_t>(row), caster, options);
  });
  return rows;
}

void add_view(const View& view, uint32_t number, const std::vector<std::vector<Shot>>& rows,
              const SimulateOptions& options, Scan& scan) {
  const float sigma = static_cast<float>(sigma_of(options));
  for (const std::vector<Shot>& row : rows) {
    for (const Shot& shot : row) {
      if (!(shot.cosine > 0)) {
        scan.rejected.push_back({view.sensor, shot.direction, kTooLittleLight, number});
        continue;
      }
      scan.points.push_back(view.sensor + shot.distance_mm * shot.direction);
      scan.ray_origins.push_back(view.sensor);
      scan.sigma_mm.push_back(sigma);
      scan.intensity.push_back(static_cast<float>(shot.cosine));
      scan.view.push_back(number);
      scan.flags.push_back(0);
    }
  }
}

// The pitch at which about options.points beams give a point. The number goes with 1 / pitch^2, so two trials
// from a coarse raster come near enough.
double choose_pitch(const Part& part, const RayCaster& caster, const SimulateOptions& options) {
  SimulateOptions trial = options;
  trial.keep_rejected = false;
  double pitch = part.radius_mm / 30;
  for (int round = 0; round < 2; ++round) {
    size_t count = 0;
    for (const View& view : make_views(part, trial, pitch)) {
      for (const std::vector<Shot>& row : shoot_view(view, 0, caster, trial)) count += row.size();
    }
    if (count == 0) return pitch;
    pitch *= std::sqrt(static_cast<double>(count) / static_cast<double>(options.points));
    // The second trial is for accuracy; beyond this many points the first is accurate enough.
    if (options.points > 200000) break;
  }
  return pitch;
}

Status check_window(const BeamWindow& window) {
  for (size_t axis = 0; axis < 2; ++axis) {
    if (!(window.angle_rad[axis] >= 0 && window.angle_rad[axis] < std::numbers::pi)) {
      return usage_error("simulate: a window's angle must be at least 0 and below 180 degrees");
    }
    if (window.rays[axis] < 1) return usage_error("simulate: a window needs at least one ray each way");
  }
  return Done{};
}

Status check_options(const SimulateOptions& options) {
  if (options.views < 1) return usage_error("simulate: at least one view is needed");
  if (options.perturbation) {
    if (!(options.perturbation->low_mm < options.perturbation->high_mm))
      return usage_error("simulate: the perturbation's low end must be below its high end");
  } else if (!(options.sigma_mm > 0)) {
    return usage_error("simulate: sigma must be above 0 mm");
  }
  if (!(options.max_incidence_rad > 0 && options.max_incidence_rad <= std::numbers::pi / 2))
    return usage_error("simulate: the largest incidence must be above 0 and at most 90 degrees");
  if (options.window) return check_window(*options.window);
  if (options.points == 0 && !(options.pitch_mm > 0))
    return usage_error("simulate: the pitch must be above 0 mm");
  return Done{};
}

Status check_sensors(const Part& part, const SimulateOptions& options) {
  for (const Vec3& sensor : sensors_of(part, options)) {
    const double distance = (sensor - part.middle).norm();
    if (distance > 1.01 * part.radius_mm) continue;
    std::ostringstream message;
    message << "simulate: a sensor " << distance
            << " mm from the middle would stand within the part's sphere (" << part.radius_mm
            << " mm); move it further away";
    return usage_error(message.str());
  }
  return Done{};
}

Status check_beams(const Part& part, const SimulateOptions& options, double pitch_mm) {
  double beams = 0;
  const std::vector<Vec3> sensors = sensors_of(part, options);
  for (const Vec3& sensor : sensors) {
    const double rows = options.window ? 0 : reach_of(part, (sensor - part.middle).norm()) / pitch_mm;
    beams += options.window ? static_cast<double>(options.window->rays[0]) * options.window->rays[1]
                            : std::numbers::pi * rows * rows;
  }
  if (beams <= kMostBeams) return Done{};
  std::ostringstream message;
  message << "simulate: ";
  if (options.window) {
    message << options.window->rays[0] << " x " << options.window->rays[1] << " rays";
  } else if (options.points > 0) {
    message << options.points << " points";
  } else {
    message << "a pitch of " << pitch_mm << " mm";
  }
  message << " on a part of " << 2 * part.radius_mm << " mm from " << sensors.size() << " views means "
          << std::setprecision(2) << beams << " rays, more than " << kMostBeams << "; "
          << (options.window       ? "lower --rays"
              : options.points > 0 ? "lower --points"
                                   : "raise --pitch or give --points")
          << ", and check the unit of the model";
  return usage_error(message.str());
}

}  // namespace

Result<Scan> simulate(const Solid& solid, const RayCaster& caster, const SimulateOptions& options) {
  const Part part = part_of(solid, options.T_scan_model);
  if (Status status = check_options(options); !status) return status.error();
  if (Status status = check_sensors(part, options); !status) return status.error();
  const bool is_by_points = options.points > 0 && !options.window;
  const double pitch = is_by_points ? choose_pitch(part, caster, options) : options.pitch_mm;
  if (Status status = check_beams(part, options, pitch); !status) return status.error();

  Scan scan;
  scan.header.seed = options.seed;
  uint32_t number = 0;
  for (const View& view : make_views(part, options, pitch)) {
    add_view(view, number, shoot_view(view, number, caster, options), options, scan);
    ++number;
  }
  if (scan.size() == 0) {
    return usage_error("simulate: no beam met the part; give a finer pitch, a wider window or more views");
  }
  return scan;
}

}  // namespace tetragauge
