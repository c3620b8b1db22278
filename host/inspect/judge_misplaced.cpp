// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/judge_misplaced.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "host/match/turn_text.hpp"

namespace tetragauge {
namespace {

std::string where_it_stands(const MisplacedFeature& feature, int face) {
  std::set<int> others;
  for (const FaceIds& pair : feature.pairs)
    if (pair.model != face) others.insert(pair.model);
  std::string names;
  for (const int id : others) names += (names.empty() ? " " : ", ") + std::to_string(id);
  return "the right shape in the wrong place: with face" + std::string(others.size() == 1 ? "" : "s") +
         names + " it stands off its place by " + vector_text(feature.shift_mm, 3) + " mm, turned by " +
         number_text(feature.turn_rad * 180 / std::numbers::pi, 3) + " degrees";
}

// How far the moved face lies from its place, at the corner where that is most.
double farthest_off(const Face& face, const FaceOutline& outline, const RigidTransform& motion) {
  double farthest = 0;
  for (const Vec3& corner : outline.corners)
    farthest = std::max(farthest, std::abs(face.normal.dot(motion * corner - corner)));
  return farthest;
}

}  // namespace

void judge_misplaced(const Solid& model, const std::vector<FaceOutline>& outlines,
                     const std::vector<SetUp>& set_ups, const Tolerances& tolerances,
                     Inspection& inspection) {
  for (const SetUp& set_up : set_ups) {
    for (const MisplacedFeature& feature : set_up.match.misplaced) {
      const RigidTransform motion = set_up.match.T_model_part * feature.T_model_part.inverse();
      for (const FaceIds& pair : feature.pairs) {
        const size_t k = static_cast<size_t>(pair.model) - 1;
        const Face& face = model.faces()[k];
        FaceInspection& out = inspection.faces[k];
        std::erase(inspection.missing_faces, pair.model);
        if (tolerances.skip.contains(face.id)) continue;
        const bool is_out = farthest_off(face, outlines[k], motion) > offset_limit(tolerances.of(face));
        if (is_out && out.verdict != Verdict::fail) {
          out.verdict = Verdict::fail;
          out.decided_by.reset();
        }
        out.reason = where_it_stands(feature, pair.model);
      }
    }
  }
}

}  // namespace tetragauge
