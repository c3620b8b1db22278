// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/measure/append_scan.hpp"

namespace tetragauge {
namespace {

template <class T>
void append(std::vector<T>& to, const std::vector<T>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

}  // namespace

void append_scan(Scan& scan, const Scan& more, uint32_t first_view) {
  append(scan.points, more.points);
  append(scan.ray_origins, more.ray_origins);
  append(scan.sigma_mm, more.sigma_mm);
  append(scan.intensity, more.intensity);
  append(scan.flags, more.flags);
  for (const uint32_t view : more.view) scan.view.push_back(first_view + view);
  for (RejectedBeam beam : more.rejected) {
    beam.view += first_view;
    scan.rejected.push_back(beam);
  }
}

void add_counts(ScanCounts& counts, const ScanCounts& more) {
  counts.beams += more.beams;
  counts.points += more.points;
  counts.table_points += more.table_points;
  counts.unsettled += more.unsettled;
  counts.one_camera += more.one_camera;
  for (size_t k = 0; k < counts.rejected.size(); ++k) counts.rejected[k] += more.rejected[k];
  counts.machine_time_s += more.machine_time_s;
  counts.timed_beams += more.timed_beams;
}

}  // namespace tetragauge
