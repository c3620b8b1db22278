// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/surface_scatter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace tetragauge {
namespace {

constexpr int kBlocks = 8;  // along the model's size: waves within such a block err together

constexpr size_t kScatterPoints = 5000;
constexpr double kMedianSquare = 0.454936;  // of a standard normal variable
constexpr double kPoseParameters = 6;

// That which, added to each point's own variance, makes half of the points as likely as half should be. Own
// sigmas differ by the angle of incidence: their median says little about all of them.
double added_variance(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals,
                      const std::map<int, double>& out) {
  std::vector<double> squares;
  const size_t count = std::min(kScatterPoints, residuals.size());
  const double size2 = problem.size_mm * problem.size_mm;
  const auto is_enough = [&](double added) {
    squares.clear();
    for (size_t i = 0; i < count; ++i) {
      const RayResidual& r = residuals[i];
      const double square = r.near ? std::pow(offset_as_made(r, out), 2) : size2;
      squares.push_back(square / (r.variance_mm2 + added));
    }
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    return *middle <= kMedianSquare;
  };
  double low = 1e-10 * size2, high = 10 * size2;
  if (is_enough(low)) return low;
  while (high > 1.001 * low) {
    const double between = std::sqrt(low * high);
    (is_enough(between) ? high : low) = between;
  }
  return high;
}

}  // namespace

double offset_as_made(const RayResidual& r, const std::map<int, double>& out) {
  const auto face = out.find(r.face);
  return face == out.end() ? r.offset_mm : r.offset_mm - face->second;
}

SurfaceScatter surface_scatter(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals,
                               const std::map<int, double>& out) {
  SurfaceScatter scatter;
  if (residuals.empty()) return scatter;
  const double added = added_variance(problem, residuals, out);
  scatter.scatter_mm = std::sqrt(added);

  // Sums over blocks scatter more than independent points' would by the number that err together (batch
  // means). Blocks are made by the place on the face, which the points' errors do not choose: a block's
  // border along a face parts its points by the sign of their errors, as if all in either half erred
  // together.
  std::map<std::array<int, 3>, double> sums;
  double squares = 0;
  const double block_mm = problem.size_mm / kBlocks;
  for (const RayResidual& r : residuals) {
    const double normalised = offset_as_made(r, out) / std::sqrt(r.variance_mm2 + added);
    if (!r.near || normalised * normalised > kMostSurprise) continue;
    const Vec3 at = (r.foot_mm - problem.pivot_mm) / block_mm;
    sums[{static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())),
          static_cast<int>(std::floor(at.z()))}] += normalised;
    squares += normalised * normalised;
  }
  double of_sums = 0;
  for (const auto& [block, sum] : sums) of_sums += sum * sum;
  const auto blocks = static_cast<double>(sums.size());
  const double fitted = kPoseParameters + static_cast<double>(out.size());
  if (squares > 0 && blocks > fitted)
    scatter.together = std::max(1.0, of_sums / squares * blocks / (blocks - fitted));
  return scatter;
}

}  // namespace tetragauge
