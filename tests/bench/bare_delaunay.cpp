// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL's Delaunay tetrahedra of a scan's points and nothing else: what script/bench pipeline compares with.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <vector>

#include "host/scan/scan_file.hpp"

int main(int argc, char** argv) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  if (argc != 2) {
    std::fprintf(stderr, "usage: tetragauge-bare-delaunay SCAN\n");
    return 2;
  }
  std::vector<Kernel::Point_3> points;
  {
    const auto scan = tetragauge::read_scan(argv[1]);
    if (!scan) {
      std::fprintf(stderr, "%s\n", scan.error().message.c_str());
      return 1;
    }
    points.reserve(scan->size());
    for (const tetragauge::Vec3& p : scan->points) points.emplace_back(p.x(), p.y(), p.z());
  }
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cores_start = std::clock();
  CGAL::Delaunay_triangulation_3<Kernel> triangulation;
  triangulation.insert(points.begin(), points.end());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const double cores_s = static_cast<double>(std::clock() - cores_start) / CLOCKS_PER_SEC;
  std::printf("%zu %.6f %.6f\n", static_cast<size_t>(triangulation.number_of_finite_cells()), seconds.count(),
              cores_s);
}
