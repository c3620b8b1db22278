// SPDX-License-Identifier: GPL-3.0-or-later
// The thesis's staircase and variants of it for the tests of the pipeline: simulated, scanned, inspected.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/inspect/inspect.hpp"
#include "host/scan/pick_points.hpp"
#include "host/simulate/simulate.hpp"

namespace tetragauge::test {

using Outline = std::vector<std::array<double, 2>>;

// The thesis's staircase, mm: a polygon in (x, z), swept over y = 0..60.
inline const Outline kStaircase{{0, 0},   {80, 0},  {80, 20}, {60, 20}, {60, 40}, {40, 40}, {40, 50},
                                {20, 50}, {20, 60}, {0, 60},  {0, 40},  {30, 10}, {0, 10}};

inline std::string swept(const Outline& xz, double from, double to) {
  std::string points;
  for (const auto& [x, z] : xz)
    points += (points.empty() ? "[" : ", [") + std::to_string(x) + ", " + std::to_string(z) + "]";
  // The sweep runs along z; its axes are turned so that it runs along y.
  return "multmatrix([[1, 0, 0, 0], [0, 0, -1, " + std::to_string(to) +
         "], [0, 1, 0, 0], [0, 0, 0, 1]]) { linear_extrude(height = " + std::to_string(to - from) +
         ", scale = [1, 1]) { polygon(points = [" + points + "], paths = undef); } }\n";
}

inline Solid solid(const std::string& csg) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
                                     (std::string("tetragauge_inspect_") + info->name() + ".csg");
  std::ofstream(path, std::ios::binary) << csg;
  Result<Solid> read = read_solid(path);
  std::filesystem::remove(path);
  if (!read) {
    ADD_FAILURE() << read.error().message;
    return {};
  }
  return std::move(read).value();
}

inline Solid staircase() {
  return solid(swept(kStaircase, 0, 60));
}

struct View {
  size_t points = 8000;
  double sigma_mm = 0.02;
  uint64_t seed = 1;
  RigidTransform T_scan_model{rotation_from_degrees(20, 30, 40), Vec3(5, 6, 7)};
};

inline Scan scan_of(const Solid& part, const View& view = {}) {
  SimulateOptions options;
  options.points = view.points;
  options.sigma_mm = view.sigma_mm;
  options.seed = view.seed;
  options.T_scan_model = view.T_scan_model;
  Result<Scan> scan = simulate(part, RayCaster(part), options);
  if (!scan) {
    ADD_FAILURE() << scan.error().message;
    return {};
  }
  return std::move(scan).value();
}

inline Tolerances profile(double mm) {
  Tolerances tolerances;
  tolerances.given = true;
  tolerances.by_default.profile_mm = mm;
  return tolerances;
}

inline InspectionRun run_inspect(const Scan& scan, const Solid& model, const Tolerances& tolerances) {
  Result<InspectionRun> run = inspect(scan, model, tolerances);
  if (!run) {
    ADD_FAILURE() << run.error().message;
    return {};
  }
  return std::move(run).value();
}

// The model's face with this normal at this offset (and centroid height, where two patches share the plane).
inline int face_at(const Solid& model, const Vec3& normal, double d_mm) {
  for (const Face& face : model.faces())
    if (face.type == SurfaceType::plane && (face.normal - normal).norm() < 1e-9 &&
        std::abs(face.d_mm - d_mm) < 1e-6)
      return face.id;
  ADD_FAILURE() << "no face at " << normal.transpose() << " " << d_mm;
  return 1;
}

// U is at k = 2: one draw in 20 lies outside it, one in 400 outside three standard uncertainties.
inline double three_sigma(double U) {
  return 1.5 * U;
}

inline const FaceInspection& result(const InspectionRun& run, int id) {
  return run.inspection.faces[static_cast<size_t>(id) - 1];
}

// The points of a scan that `keep(i)` says.
template <class Keep>
Scan points_of(const Scan& whole, const Keep& keep) {
  std::vector<uint32_t> kept;
  for (uint32_t i = 0; i < whole.size(); ++i) {
    if (keep(i)) kept.push_back(i);
  }
  return pick_points(whole, kept);
}

}  // namespace tetragauge::test
