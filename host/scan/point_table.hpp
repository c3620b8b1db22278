// SPDX-License-Identifier: GPL-3.0-or-later
// What every point file is turned into first: named columns of numbers. Used by scan_file.cpp alone.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/result.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge {

struct PointTable {
  size_t rows = 0;
  std::map<std::string, std::vector<double>> columns;  // each of `rows` numbers, as they stand in the file
  double unit_scale_mm = 1.0;                          // from a `comment unit`, else 1
  ScanHeader header;
  std::vector<RejectedBeam> rejected;
};

// `name` is said in errors. Counts in headers are checked against the bytes there before anything is
// allocated.
Result<PointTable> parse_ply(std::string_view content, const std::string& name);
Result<PointTable> parse_pcd(std::string_view content, const std::string& name);  // DATA ascii
// Columns x y z [nx ny nz], or as the first line names them; blanks, tabs, commas or semicolons between.
Result<PointTable> parse_xyz(std::string_view content, const std::string& name);

}  // namespace tetragauge
