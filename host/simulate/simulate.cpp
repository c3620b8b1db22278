// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/simulate/simulate.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

#include "host/simulate/counter_noise.hpp"

namespace tetragauge {
namespace {

// More beams than this is a pitch too fine for the part, or a part in the wrong unit, not a scan: its file
// would have hundreds of megabytes, and memory several times that.
constexpr double kMostBeams = 2e7;

// REJECT_WEAK of protocol/machine.proto: too little light came back.
constexpr uint32_t kTooLittleLight = 1;

constexpr double kStandoffRadii = 4;

// One view: beams from one point through a square raster on the plane across the view through the middle of
// the part, in the scan frame.
struct View {
  Vec3 sensor, middle, u, v;
  double pitch_mm = 0, reach_mm = 0;
  int64_t rows = 0;

  // The beam through row j, column i; the raster's middle lies between beams.
  Vec3 direction(int64_t j, int64_t i) const {
    const Vec3 target = middle + coordinate(i) * u + coordinate(j) * v;
    return (target - sensor).normalized();
  }
  double coordinate(int64_t i) const {
    return pitch_mm * (static_cast<double>(i) - 0.5 * static_cast<double>(rows - 1));
  }
  bool is_in_reach(int64_t j, int64_t i) const {
    return std::hypot(coordinate(i), coordinate(j)) <= reach_mm + pitch_mm;
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

std::vector<View> make_views(const Part& part, const SimulateOptions& options, double pitch_mm) {
  const double standoff = standoff_of(part, options), reach = reach_of(part, standoff);
  std::vector<View> views;
  for (const Vec3& direction : view_directions(options.views)) {
    const auto [u, v] = tangent_frame(direction);
    const int64_t rows = 2 * static_cast<int64_t>(std::ceil(reach / pitch_mm)) + 2;
    views.push_back({part.middle + standoff * direction, part.middle, u, v, pitch_mm, reach, rows});
  }
  return views;
}

struct Shot {
  int64_t column = 0;
  Vec3 direction = Vec3::Zero();  // scan frame
  double distance_mm = 0;
  double cosine = 0;  // of the incidence; 0: no point
};

std::vector<Shot> shoot_row(const View& view, int64_t row, const RayCaster& caster,
                            const SimulateOptions& options) {
  const RigidTransform T_model_scan = options.T_scan_model.inverse();
  const Vec3 origin = T_model_scan * view.sensor;
  const double least_cosine = std::cos(options.max_incidence_rad);
  std::vector<Shot> shots;
  for (int64_t column = 0; column < view.rows; ++column) {
    if (!view.is_in_reach(row, column)) continue;
    Shot shot;
    shot.column = column;
    shot.direction = view.direction(row, column);
    const Vec3 direction = T_model_scan.R * shot.direction;
    const auto hit = caster.first_hit(origin, direction);
    if (hit && -hit->normal.dot(direction) >= least_cosine) {
      shot.distance_mm = hit->distance_mm;
      shot.cosine = -hit->normal.dot(direction);
    }
    if (shot.cosine > 0 || options.keep_rejected) shots.push_back(shot);
  }
  return shots;
}

std::vector<std::vector<Shot>> shoot_view(const View& view, const RayCaster& caster,
                                          const SimulateOptions& options) {
  std::vector<std::vector<Shot>> rows(static_cast<size_t>(view.rows));
  tbb::parallel_for(size_t{0}, rows.size(), [&](size_t row) {
    rows[row] = shoot_row(view, static_cast<int64_t>(row), caster, options);
  });
  return rows;
}

void add_view(const View& view, uint32_t number, const std::vector<std::vector<Shot>>& rows,
              const SimulateOptions& options, Scan& scan) {
  for (size_t row = 0; row < rows.size(); ++row) {
    for (const Shot& shot : rows[row]) {
      if (!(shot.cosine > 0)) {
        scan.rejected.push_back({view.sensor, shot.direction, kTooLittleLight, number});
        continue;
      }
      const uint64_t ray =
          static_cast<uint64_t>(row) * static_cast<uint64_t>(view.rows) + static_cast<uint64_t>(shot.column);
      const double distance = shot.distance_mm + options.sigma_mm * counter_normal(options.seed, number, ray);
      scan.points.push_back(view.sensor + distance * shot.direction);
      scan.ray_origins.push_back(view.sensor);
      scan.sigma_mm.push_back(static_cast<float>(options.sigma_mm));
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
      for (const std::vector<Shot>& row : shoot_view(view, caster, trial)) count += row.size();
    }
    if (count == 0) return pitch;
    pitch *= std::sqrt(static_cast<double>(count) / static_cast<double>(options.points));
    // The second trial is for accuracy; beyond this many points the first is accurate enough.
    if (options.points > 200000) break;
  }
  return pitch;
}

Status check_options(const Part& part, const SimulateOptions& options) {
  if (options.views < 1) return usage_error("simulate: at least one view is needed");
  if (!(options.sigma_mm > 0)) return usage_error("simulate: sigma must be above 0 mm");
  if (options.points == 0 && !(options.pitch_mm > 0))
    return usage_error("simulate: the pitch must be above 0 mm");
  if (options.standoff_mm > 0 && options.standoff_mm <= 1.01 * part.radius_mm) {
    std::ostringstream message;
    message << "simulate: a sensor " << options.standoff_mm
            << " mm from the middle would stand within the part (" << part.radius_mm
            << " mm); move it further away";
    return usage_error(message.str());
  }
  return Done{};
}

Status check_beams(const Part& part, const SimulateOptions& options, double pitch_mm) {
  const double rows = reach_of(part, standoff_of(part, options)) / pitch_mm;
  const double beams = std::numbers::pi * rows * rows * options.views;
  if (beams <= kMostBeams) return Done{};
  std::ostringstream message;
  message << "simulate: ";
  if (options.points > 0) {
    message << options.points << " points";
  } else {
    message << "a pitch of " << pitch_mm << " mm";
  }
  message << " on a part of " << 2 * part.radius_mm << " mm from " << options.views << " views means "
          << std::setprecision(2) << beams << " rays, more than " << kMostBeams << "; "
          << (options.points > 0 ? "lower --points" : "raise --pitch or give --points")
          << ", and check the unit of the model";
  return usage_error(message.str());
}

}  // namespace

Result<Scan> simulate(const Solid& solid, const RayCaster& caster, const SimulateOptions& options) {
  const Part part = part_of(solid, options.T_scan_model);
  if (Status status = check_options(part, options); !status) return status.error();
  const double pitch = options.points > 0 ? choose_pitch(part, caster, options) : options.pitch_mm;
  if (Status status = check_beams(part, options, pitch); !status) return status.error();

  Scan scan;
  scan.header.seed = options.seed;
  uint32_t number = 0;
  for (const View& view : make_views(part, options, pitch)) {
    add_view(view, number, shoot_view(view, caster, options), options, scan);
    ++number;
  }
  if (scan.size() == 0) {
    return usage_error("simulate: no beam met the part; give a finer pitch or more views");
  }
  return scan;
}

}  // namespace tetragauge
