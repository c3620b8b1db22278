// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/search_poses.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

// Weight that a rotation can explain that was built from no pair among the first `count` directions: all but
// those, and of those only what lies along one line.
double most_unseen(const PlaneSet& measured, size_t count) {
  double first = 0, longest_line = 0;
  for (size_t i = 0; i < count; ++i) {
    first += measured.directions[i].weight;
    double line = 0;
    for (size_t k = 0; k < count; ++k)
      if (std::abs(measured.directions[i].normal.dot(measured.directions[k].normal)) > 0.99)
        line += measured.directions[k].weight;
    longest_line = std::max(longest_line, line);
  }
  return measured.weight - first + longest_line;
}

}  // namespace

bool holds_fixed(const PlaneSet& model, const PlaneSet& measured, const RigidTransform& T,
                 const SearchGates& gates, bool with_offset) {
  const auto& fixed = gates.allowed.fixed;
  return std::all_of(fixed.begin(), fixed.end(), [&](const AllowedPairs::Pair& pair) {
    const MatchPlane &face = model.planes[pair.first], &seen = measured.planes[pair.second];
    const double cosine = face.normal.dot(T.R * seen.normal);
    if ((gates.is_unsigned ? std::abs(cosine) : cosine) < std::cos(kFixedGates * gates.angle_rad))
      return false;
    return !with_offset ||
           std::abs(face.normal.dot(T * seen.point_mm) - face.d_mm) <= kFixedGates * gates.offset_mm;
  });
}

std::vector<PoseCandidate> search_poses(const PlaneSet& model, const PlaneSet& measured,
                                        const SearchGates& gates, double keep) {
  std::vector<PoseCandidate> found;
  const size_t all = measured.directions.size();
  for (size_t count = std::min<size_t>(all, 5);; count = std::min(all, 2 * count)) {
    found.clear();
    double best = 0;
    for (const RotationCandidate& rotation : search_rotations(model, measured, count, gates)) {
      const double least = std::max(keep * best, 1e-3 * measured.weight);
      if (rotation.explained < least) break;
      for (const PoseCandidate& pose : search_translations(model, measured, rotation.R, gates, least, keep)) {
        best = std::max(best, pose.explained);
        found.push_back(pose);
      }
    }
    std::erase_if(found, [&](const PoseCandidate& pose) { return pose.explained < keep * best; });
    // Complete when no pose built from other directions could come near the best one.
    if (count == all || most_unseen(measured, count) < keep * best) break;
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.explained > b.explained; });
  return found;
}

}  // namespace tetragauge
