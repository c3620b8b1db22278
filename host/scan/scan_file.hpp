// SPDX-License-Identifier: GPL-3.0-or-later
// Scan files: our PLY (binary little-endian; ASCII is read too), and clouds of others without rays.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "host/base/result.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge {

struct ReadScanOptions {
  std::optional<double> unit_scale_mm = {};  // mm per unit of the file; else its own word, else 1
  std::optional<Vec3> ray_origin_mm = {};    // one sensor, mm: for files without rays
  std::optional<Vec3> ray_direction = {};    // parallel rays: the way the light travels
  std::optional<double> sigma_mm = {};       // for files without sigma; overrides nothing that is there
};

// By its ending: .ply, .pcd (text), .xyz/.csv/.txt. Errors name file and place. 0 points is an error.
Result<Scan> read_scan(const std::filesystem::path& path, const ReadScanOptions& options = {});

Status write_scan(const std::filesystem::path& path, const Scan& scan);
std::string scan_to_ply(const Scan& scan);

}  // namespace tetragauge
