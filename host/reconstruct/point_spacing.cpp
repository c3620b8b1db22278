// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/point_spacing.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tetragauge {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Search = CGAL::Orthogonal_k_neighbor_search<CGAL::Search_traits_3<Kernel>>;

}  // namespace

double point_spacing(std::span<const Vec3> points, double sigma_mm) {
  const size_t n = points.size();
  if (n < 2) return 0;
  std::vector<Kernel::Point_3> all;
  all.reserve(n);
  for (const Vec3& p : points) all.emplace_back(p.x(), p.y(), p.z());
  Search::Tree tree(all.begin(), all.end());
  tree.build();

  const size_t samples = std::min<size_t>(n, 2000);
  std::vector<double> spacings;
  spacings.reserve(samples);
  for (size_t i = 0; i < samples; ++i) {
    const Kernel::Point_3& p = all[i * n / samples];
    for (size_t k = 8;; k *= 4) {
      const auto count = static_cast<unsigned int>(std::min(k, n - 1) + 1);  // the point itself comes first
      Search search(tree, p, count);
      double radius2 = 0;
      for (const auto& found : search) radius2 = std::max(radius2, found.second);
      const double radius = std::sqrt(radius2);
      if (radius < 6 * sigma_mm && count < n && k < 2048) continue;
      // A disc of this radius holds count points, the outermost on its rim counted half.
      spacings.push_back(radius * std::sqrt(std::numbers::pi / (count - 0.5)));
      break;
    }
  }
  std::nth_element(spacings.begin(), spacings.begin() + static_cast<long>(samples / 2), spacings.end());
  return spacings[samples / 2];
}

}  // namespace tetragauge
