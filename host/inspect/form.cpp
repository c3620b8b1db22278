// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/form.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace tetragauge {
namespace {

constexpr double kLeastPoints = 4;

// Inverse of the standard normal distribution, by bisection: called a few times per face.
double normal_quantile(double p) {
  double low = -10, high = 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Cell {
  double sum = 0, squares = 0, count = 0;
};

}  // namespace

double expected_range(size_t n) {
  if (n < 2) return 0;
  const double k = static_cast<double>(n);
  return 2 * normal_quantile((k - 0.375) / (k + 0.25));
}

Form form_deviation(std::span<const Vec3> place, std::span<const double> residual, double area_mm2,
                    double tolerance_mm) {
  Form form;
  const double n = static_cast<double>(place.size());
  if (n < 2 * kLeastPoints) return form;
  Vec3 low = place[0];
  double squares = 0;
  for (size_t k = 0; k < place.size(); ++k) {
    low = low.cwiseMin(place[k]);
    squares += residual[k] * residual[k];
  }
  // Two rounds: the noise is known only once form has been taken out of the cells.
  double noise = std::sqrt(squares / n);
  std::map<std::array<long, 3>, Cell> cells;
  for (int round = 0; round < 2; ++round) {
    const double wanted = std::max(kLeastPoints, std::pow(20 * noise / tolerance_mm, 2));
    // Twice the wanted points on average, as cells at a slanted boundary are partly empty.
    const double side = std::sqrt(2 * wanted * std::max(1e-12, area_mm2) / n);
    cells.clear();
    for (size_t k = 0; k < place.size(); ++k) {
      const Vec3 at = (place[k] - low) / side;
      Cell& cell = cells[{static_cast<long>(at.x()), static_cast<long>(at.y()), static_cast<long>(at.z())}];
      cell.sum += residual[k];
      cell.squares += residual[k] * residual[k];
      ++cell.count;
    }
    double within = 0, freedom = 0;
    for (auto& [at, cell] : cells) {
      within += std::max(0.0, cell.squares - cell.sum * cell.sum / cell.count);
      freedom += cell.count - 1;
    }
    if (freedom > 0) noise = std::sqrt(within / freedom);
    std::erase_if(cells, [&](const auto& entry) { return entry.second.count < wanted; });
  }
  if (cells.empty()) return form;
  double variance = 0;
  form.highest_mm = -1e300;
  form.lowest_mm = 1e300;
  for (const auto& [at, cell] : cells) {
    const double mean = cell.sum / cell.count;
    form.highest_mm = std::max(form.highest_mm, mean);
    form.lowest_mm = std::min(form.lowest_mm, mean);
    variance += noise * noise / cell.count;
  }
  form.cells = cells.size();
  const double of_mean = std::sqrt(variance / static_cast<double>(form.cells));
  const double range = form.highest_mm - form.lowest_mm;
  // Linear, not in quadrature: where form and noise add, the highest and the lowest cell are each raised by
  // the largest noise of the cells at that height, which is at most half of the expected range.
  form.form_mm = std::max(0.0, range - expected_range(form.cells) * of_mean);
  form.U_mm = 2 * std::sqrt(2.0) * of_mean;  // of a difference of two cells
  return form;
}

}  // namespace tetragauge
