// SPDX-License-Identifier: GPL-3.0-or-later
// Fuzzes what reads scans. The first byte chooses the ending and what else is told: see below.
#include <array>
#include <cmath>

#include "host/scan/scan_file.hpp"
#include "tests/fuzz/check_error.hpp"

using namespace tetragauge;
using fuzz::must;

namespace {

void check_scan(const Scan& scan) {
  const size_t n = scan.size();
  must(n > 0, "a scan has points");
  must(scan.ray_origins.size() == n && scan.sigma_mm.size() == n && scan.intensity.size() == n &&
           scan.view.size() == n && scan.flags.size() == n,
       "columns are of one length");
  for (size_t i = 0; i < n; ++i) {
    must(scan.points[i].allFinite() && scan.ray_origins[i].allFinite(), "coordinates are numbers");
    must(std::abs(scan.ray_direction(i).norm() - 1) < 1e-9, "rays have a direction");
    must(scan.sigma_mm[i] > 0 && std::isfinite(scan.sigma_mm[i]), "sigma is a number above 0");
    must(std::isfinite(scan.intensity[i]), "intensity is a number");
  }
  for (const RejectedBeam& beam : scan.rejected) must(beam.origin.allFinite(), "beams start somewhere");
  const std::string ply = scan_to_ply(scan);
  const Result<Scan> again = read_scan(fuzz::input_file(ply, "_again.ply"));
  must(again.ok(), "what is written is read");
  must(scan_to_ply(*again) == ply, "what is read again is the same");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  constexpr std::array kEndings{".ply", ".pcd", ".xyz", ".csv"};
  ReadScanOptions options;
  if (data[0] & 4) options.unit_scale_mm = 1000.0;
  if (data[0] & 8) options.ray_origin_mm = Vec3(0, 0, 400);
  if (data[0] & 16) options.ray_direction = Vec3(0, 0, -1);
  if (data[0] & 32) options.sigma_mm = 0.03;
  const std::string_view content(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::filesystem::path path = fuzz::input_file(content, kEndings[data[0] % kEndings.size()]);
  const Result<Scan> scan = read_scan(path, options);
  scan ? check_scan(*scan) : fuzz::check_error(scan.error(), path.string());
  return 0;
}
