// SPDX-License-Identifier: GPL-3.0-or-later
// usage: tetragauge-rays [COUNT]    random rays through adversarial point sets, most of them through
// vertices, edges and along facets; says how many were lost, which must be none. 1e8 rays unless COUNT says
// otherwise.
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <set>
#include <tuple>

#include "host/reconstruct/walk_ray.hpp"

namespace tetragauge {
namespace {

struct PointSet {
  const char* name;
  std::vector<Vec3> points;
};

std::vector<PointSet> point_sets() {
  PointSet grid{"grid", {}}, planes{"two planes", {}}, lines{"two skew lines", {}}, sphere{"sphere", {}},
      duplicates{"near duplicates", {}}, random{"random", {}};
  for (int x = 0; x < 12; ++x) {
    for (int y = 0; y < 12; ++y) {
      for (int z = 0; z < 12; ++z) grid.points.emplace_back(x, y, z);
      planes.points.emplace_back(x, y, 0);
      planes.points.emplace_back(x, y, 3);
      for (int copy = 0; copy < 4; ++copy)
        duplicates.points.emplace_back(x + copy * 0x1p-40, y - copy * 0x1p-41, (x + y) % 3 + copy * 0x1p-39);
    }
  }
  for (int i = 0; i < 60; ++i) {
    lines.points.emplace_back(i, 0, 0);
    lines.points.emplace_back(0, i, 5);
  }
  for (int i = 0; i < 40; ++i) {
    for (int k = -9; k <= 9; ++k)
      sphere.points.emplace_back(10 * std::cos(M_PI * i / 20) * std::cos(M_PI * k / 20),
                                 10 * std::sin(M_PI * i / 20) * std::cos(M_PI * k / 20),
                                 10 * std::sin(M_PI * k / 20));
  }
  std::mt19937 generator(7);
  for (int i = 0; i < 3000; ++i)
    random.points.emplace_back(generator() % 97, generator() % 97, generator() % 97);
  std::vector<PointSet> sets;
  for (PointSet* set : {&grid, &planes, &lines, &sphere, &duplicates, &random}) {
    const auto before = [](const Vec3& a, const Vec3& b) {
      return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
    };
    std::set<Vec3, decltype(before)> distinct(set->points.begin(), set->points.end(), before);
    sets.push_back({set->name, {distinct.begin(), distinct.end()}});
  }
  return sets;
}

// Some seconds' worth: how often a terminal hears how far it has got.
constexpr size_t kRaysToNews = 1000000;

struct Count {
  size_t walked = 0, lost = 0, steps = 0;
};

// The rays numbered first to last - 1.
Count walk_many(const Tetrahedra& tetrahedra, size_t first, size_t last, uint32_t set) {
  struct Local {
    RayWalker walker;
    Walk walk;
    Count count;
  };
  tbb::enumerable_thread_specific<Local> locals([&] { return Local{RayWalker(tetrahedra), {}, {}}; });
  const size_t n = tetrahedra.vertices.size();
  tbb::parallel_for(
      tbb::blocked_range<size_t>(first, last, 4096), [&](const tbb::blocked_range<size_t>& range) {
        Local& local = locals.local();
        for (size_t k = range.begin(); k < range.end(); ++k) {
          // A pure function of the ray's number: the same rays for any number of threads.
          std::minstd_rand generator(static_cast<uint32_t>(k * 2654435761u + set));
          const auto pick = [&] { return tetrahedra.vertices[generator() % n]; };
          const auto start = static_cast<uint32_t>(generator() % n);
          const Vec3& p = tetrahedra.vertices[start];
          // Through another vertex, the middle of two, in line with the axes, or anywhere.
          Vec3 target = pick();
          switch (k % 4) {
            case 0:
              target = p + 3 * (target - p);
              break;
            case 1:
              target = p + 8 * (0.5 * (target + pick()) - p);
              break;
            case 2:
              target = p + (k % 8 < 4 ? 1000.0 : -1000.0) * Vec3::Unit(static_cast<int>(k / 8 % 3));
              break;
            default:
              target += 1e-3 * pick();
          }
          local.walker.walk(start, target, local.walk);
          ++local.count.walked;
          local.count.steps += local.walk.steps.size();
          if (local.walk.end == Walk::End::lost) ++local.count.lost;
        }
      });
  Count total;
  for (const Local& local : locals) {
    total.walked += local.count.walked;
    total.lost += local.count.lost;
    total.steps += local.count.steps;
  }
  return total;
}

int run(size_t rays) {
  const std::vector<PointSet> sets = point_sets();
  const bool is_watched = isatty(STDERR_FILENO);
  size_t walked = 0, lost = 0;
  std::printf("%-18s %8s %12s %14s %10s %8s\n", "set", "points", "rays", "cells crossed", "rays_lost", "s");
  for (uint32_t s = 0; s < sets.size(); ++s) {
    const auto tetrahedra = delaunay(sets[s].points);
    if (!tetrahedra) {
      std::fprintf(stderr, "%s: %s\n", sets[s].name, tetrahedra.error().message.c_str());
      return 70;
    }
    const auto start = std::chrono::steady_clock::now();
    Count count;
    const size_t own = rays / sets.size() + 1;
    for (size_t first = 0; first < own; first += kRaysToNews) {
      const Count some = walk_many(*tetrahedra, first, std::min(own, first + kRaysToNews), s);
      count.walked += some.walked;
      count.lost += some.lost;
      count.steps += some.steps;
      if (is_watched)
        std::fprintf(stderr, "\r%s: %zu of %zu rays, %zu lost ", sets[s].name, count.walked, own, count.lost);
    }
    if (is_watched) std::fprintf(stderr, "\r%60s\r", "");
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("%-18s %8zu %12zu %14zu %10zu %8.1f\n", sets[s].name, sets[s].points.size(), count.walked,
                count.steps, count.lost, seconds);
    std::fflush(stdout);
    walked += count.walked;
    lost += count.lost;
  }
  std::printf("%zu rays, %zu lost\n", walked, lost);
  return lost == 0 ? 0 : 1;
}

}  // namespace
}  // namespace tetragauge

int main(int argc, char** argv) {
  const double count = argc > 1 ? std::strtod(argv[1], nullptr) : 1e8;
  if (argc > 2 || !(count >= 1) || !(count <= 1e12)) {
    std::fprintf(stderr, "usage: tetragauge-rays [COUNT]    COUNT: rays, 1 to 1e12; 1e8 if not given\n");
    return 2;
  }
  return tetragauge::run(static_cast<size_t>(count));
}
