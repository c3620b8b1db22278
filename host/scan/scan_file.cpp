// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/scan/scan_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "host/base/excerpt.hpp"
#include "host/base/whole_file.hpp"
#include "host/scan/point_table.hpp"

namespace tetragauge {
namespace {

// From here on a cloud is a table of named columns, whatever the file was.
Result<Scan> scan_from_table(PointTable table, const ReadScanOptions& options, const std::string& name) {
  const size_t n = table.rows;
  if (n == 0) return bad_input(name + ": 0 points; nothing to work on");
  const auto column = [&](std::string_view key) -> const std::vector<double>* {
    const auto found = table.columns.find(std::string(key));
    return found == table.columns.end() ? nullptr : &found->second;
  };
  const auto vectors = [&](std::string_view x, std::string_view y, std::string_view z) {
    std::vector<Vec3> list;
    const auto *cx = column(x), *cy = column(y), *cz = column(z);
    if (cx && cy && cz) {
      list.reserve(n);
      for (size_t i = 0; i < n; ++i) list.emplace_back((*cx)[i], (*cy)[i], (*cz)[i]);
    }
    return list;
  };

  Scan scan;
  scan.header = std::move(table.header);
  if (!(scan.header.u_cal_mm >= 0)) return bad_input(name + ": header: u_cal_mm must not be negative");
  if (!(scan.header.spot_mm >= 0)) return bad_input(name + ": header: spot_mm must not be negative");
  const double scale = options.unit_scale_mm.value_or(table.unit_scale_mm);
  scan.points = vectors("x", "y", "z");
  if (scan.points.empty()) return bad_input(name + ": no columns x, y, z");
  for (size_t i = 0; i < n; ++i) {
    // A point 1 km away is a broken number, and would cost every digit of the others.
    if (!scan.points[i].allFinite() || scan.points[i].cwiseAbs().maxCoeff() * scale > 1e6) {
      return bad_input(name + ": point " + std::to_string(i) +
                       ": coordinate is not a finite number below 1 km; remove " +
                       "the point or repair the file");
    }
    scan.points[i] *= scale;
  }

  scan.ray_origins = vectors("ray_x", "ray_y", "ray_z");
  for (Vec3& origin : scan.ray_origins) origin *= scale;
  if (scan.ray_origins.empty() && options.ray_origin_mm) scan.ray_origins.assign(n, *options.ray_origin_mm);
  // Without true sensor places the ray only has a direction: it starts well outside the part.
  double reach_mm = 1;
  if (scan.ray_origins.empty()) {
    Vec3 low = scan.points[0], high = scan.points[0];
    for (const Vec3& p : scan.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    reach_mm = std::max(1.0, 2 * (high - low).norm());
  }
  if (scan.ray_origins.empty() && options.ray_direction) {
    const Vec3 step = options.ray_direction->normalized() * reach_mm;
    for (const Vec3& p : scan.points) scan.ray_origins.push_back(p - step);
  }
  if (scan.ray_origins.empty()) {
    const std::vector<Vec3> normals = vectors("nx", "ny", "nz");
    for (size_t i = 0; i < normals.size(); ++i) {
      if (!(normals[i].norm() > 1e-6) || !std::isfinite(normals[i].norm()))
        return bad_input(name + ": point " + std::to_string(i) +
                         ": its normal is zero or not finite; remove the point or give " +
                         "--ray-origin or --ray-direction");
      scan.ray_origins.push_back(scan.points[i] + normals[i].normalized() * reach_mm);
    }
  }
  if (scan.ray_origins.empty()) {
    return bad_input(
        name + ": no rays in the file (ray_x ray_y ray_z, or normals nx ny nz); say where it was measured " +
        "from: --ray-origin X,Y,Z (one sensor) or --ray-direction X,Y,Z (parallel rays)");
  }
  for (size_t i = 0; i < n; ++i) {
    const double length_mm = (scan.points[i] - scan.ray_origins[i]).norm();
    if (!(length_mm > 1e-9) || length_mm > 1e9) {
      return bad_input(name + ": point " + std::to_string(i) +
                       ": its ray has no direction (its origin is the point itself, beyond 1000 km, or " +
                       "not finite); remove the point or repair the file");
    }
  }

  if (const auto* sigma = column("sigma")) {
    for (size_t i = 0; i < n; ++i) {
      const double sigma_mm = (*sigma)[i] * scale;
      if (!(static_cast<float>(sigma_mm) > 0) || sigma_mm > 1e6) {
        return bad_input(name + ": point " + std::to_string(i) +
                         ": sigma must be a number above 0 (and below 1 km); remove " +
                         "the point or repair the file");
      }
      scan.sigma_mm.push_back(static_cast<float>(sigma_mm));
    }
  } else if (options.sigma_mm) {
    scan.sigma_mm.assign(n, static_cast<float>(*options.sigma_mm));
  } else {
    return bad_input(
        name + ": no sigma in the file; give the sensor's standard deviation along its ray: --sigma MM");
  }

  scan.intensity.assign(n, 1.0f);
  if (const auto* values = column("intensity")) {
    for (size_t i = 0; i < n; ++i) {
      if (!(std::abs((*values)[i]) <= static_cast<double>(std::numeric_limits<float>::max()))) {
        return bad_input(name + ": point " + std::to_string(i) +
                         ": intensity is not a finite number; remove the point or the column");
      }
      scan.intensity[i] = static_cast<float>((*values)[i]);
    }
  }
  const auto whole = [&](std::string_view key, std::vector<uint32_t>& out) -> Status {
    out.assign(n, 0);
    const auto* values = column(key);
    if (!values) return Done{};
    for (size_t i = 0; i < n; ++i) {
      if (!((*values)[i] >= 0 && (*values)[i] <= 4294967295.0 && (*values)[i] == std::floor((*values)[i]))) {
        return bad_input(name + ": point " + std::to_string(i) + ": " + std::string(key) +
                         " is not a whole number from 0; repair the file");
      }
      out[i] = static_cast<uint32_t>((*values)[i]);
    }
    return Done{};
  };
  if (Status status = whole("view", scan.view); !status) return status.error();
  if (Status status = whole("flags", scan.flags); !status) return status.error();
  scan.rejected = std::move(table.rejected);
  for (RejectedBeam& beam : scan.rejected) beam.origin *= scale;
  return scan;
}

}  // namespace

Result<Scan> read_scan(const std::filesystem::path& path, const ReadScanOptions& options) {
  Result<std::string> content = read_whole_file(path);
  if (!content) return content.error();
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  const std::string name = path.string();
  Result<PointTable> table =
      ending == ".ply"   ? parse_ply(*content, name)
      : ending == ".pcd" ? parse_pcd(*content, name)
      : ending == ".xyz" || ending == ".csv" || ending == ".txt"
          ? parse_xyz(*content, name)
          : Result<PointTable>(bad_input(name + ": unknown ending '" + excerpt(ending) +
                                         "'; a scan is .ply, .pcd (text), .xyz, .csv or .txt"));
  if (!table) return table.error();
  return scan_from_table(std::move(*table), options, name);
}

Status write_scan(const std::filesystem::path& path, const Scan& scan) {
  return write_whole_file(path, scan_to_ply(scan));
}

}  // namespace tetragauge
