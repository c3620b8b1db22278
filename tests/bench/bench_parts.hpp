// SPDX-License-Identifier: GPL-3.0-or-later
// Planar parts for the matrix of accuracy, as .csg text. Every kind has nominal sizes, or random ones by
// seed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tetragauge::bench {

struct BenchPart {
  std::string name;
  std::string csg;
};

std::vector<std::string> bench_part_names();

// `seed` 0: nominal sizes; otherwise sizes drawn from the seed. Precondition: the name is one of the names.
BenchPart bench_part(const std::string& name, uint64_t seed = 0);

}  // namespace tetragauge::bench
