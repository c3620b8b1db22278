// SPDX-License-Identifier: GPL-3.0-or-later
// The matrix of accuracy: parts x sigma x number of points, each in a random pose, as a table.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/bench/measure_cell.hpp"

using namespace tetragauge;
using namespace tetragauge::bench;

namespace {

// The same cell has the same pose and noise whichever others are asked for (FNV-1a of its name).
uint64_t cell_seed(const std::string& part, size_t points, double sigma_mm, uint64_t seed) {
  uint64_t hash = 14695981039346656037u;
  const std::string name =
      part + "/" + std::to_string(points) + "/" + std::to_string(std::lround(1e6 * sigma_mm));
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return (hash ^ seed) & 0xffffffffffff;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Parts x sigma x points, each in a random pose: how many cells reach the goal");
  bool full = false, quiet = false;
  uint64_t seed = 1, sizes = 0;
  std::vector<std::string> parts = bench_part_names();
  std::vector<double> sigmas{0.01, 0.03, 0.1};
  std::vector<size_t> counts{5000, 50000};
  app.add_flag("--full", full, "500,000 points too");
  app.add_flag("--missing", quiet, "Only the cells that miss");
  app.add_option("--seed", seed, "Of poses and noise")->capture_default_str();
  app.add_option("--sizes", sizes, "Seed of random sizes; 0: nominal ones")->capture_default_str();
  app.add_option("--part", parts, "Only these parts");
  app.add_option("--sigma", sigmas, "mm");
  app.add_option("--points", counts);
  std::string save_to;
  app.add_option("--save", save_to, "Folder for the scans of cells that miss, for `tetragauge faces --out`");
  CLI11_PARSE(app, argc, argv);
  if (full) counts.push_back(500000);

  std::printf("%-22s %6s %7s %6s %6s %8s %7s %7s %7s %7s %8s %8s %6s %6s\n", "part", "sigma", "points",
              "space", "faces", "invented", "chamfer", "offset", "tilt", "area%", "volume%", "mesh", "rec s",
              "fac s");
  size_t cells = 0, passed = 0;
  const std::vector<std::string> names = bench_part_names();
  for (const std::string& name : parts) {
    const auto number = static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    const BenchPart part = bench_part(name, sizes == 0 ? 0 : 1000 * sizes + number);
    const Result<Solid> solid = solid_of(part);
    if (!solid) {
      std::fprintf(stderr, "%s: %s\n", part.name.c_str(), solid.error().message.c_str());
      return 1;
    }
    for (const size_t points : counts) {
      for (const double sigma : sigmas) {
        CellOptions options;
        options.points = points;
        options.sigma_mm = sigma;
        options.save_to = save_to;
        options.seed = cell_seed(part.name, points, sigma, seed);
        ++cells;
        const Result<Cell> cell = measure_cell(part.name, *solid, options);
        if (!cell) {
          std::fprintf(stderr, "%s: %s\n", part.name.c_str(), cell.error().message.c_str());
          return 1;
        }
        if (cell->passes()) ++passed;
        if (quiet && cell->passes()) continue;
        std::printf(
            "%-22s %6.3f %7zu %6.2f %3zu/%-3zu %7zu %7zu %7.2f %7.2f %7.1f %8.3f %8.2f %6.2f %6.2f %s\n",
            cell->part.c_str(), sigma, cell->points, cell->spacing_mm, cell->found, cell->wanted,
            cell->invented, cell->false_chamfers, cell->worst_offset, cell->worst_tilt_mrad,
            100 * cell->worst_area, 100 * cell->boundary_volume, cell->mesh_volume, cell->reconstruct_s,
            cell->faces_s, cell->passes() ? "" : "MISS");
        for (const std::string& note : cell->notes) std::printf("    %s\n", note.c_str());
        std::fflush(stdout);
      }
    }
  }
  std::printf("%zu of %zu cells reach the goal\n", passed, cells);
  return passed == cells ? 0 : 1;
}
