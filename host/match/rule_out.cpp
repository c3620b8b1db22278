// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/rule_out.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>

#include "host/match/turn_text.hpp"

namespace tetragauge {
namespace {

// More faces than these need not be named.
constexpr size_t kMostNamed = 3;

std::string text(const char* format, auto... values) {
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

const PlanePair* pair_of(const RankedPose& pose, size_t measured) {
  const auto at = std::find_if(pose.pairs.begin(), pose.pairs.end(),
                               [&](const PlanePair& pair) { return pair.measured == measured; });
  return at == pose.pairs.end() ? nullptr : &*at;
}

}  // namespace

RuledOutPose ruled_out_by_faces(const MatchInput& input, const RankedPoses& ranked, const RankedPose& best,
                                const RankedPose& rival) {
  const auto costs = [&](const RankedPose& pose) {
    return face_costs(input.model, input.measured, pose.pose.T_model_part, pose.pairs, ranked.scatter_mm,
                      ranked.scatter_rad);
  };
  const std::vector<double> in_best = costs(best), in_rival = costs(rival);
  std::vector<size_t> deciding;  // measured faces, the strongest first
  for (size_t j = 0; j < in_best.size(); ++j)
    if (in_rival[j] - in_best[j] > 1 && pair_of(best, j)) deciding.push_back(j);
  std::stable_sort(deciding.begin(), deciding.end(),
                   [&](size_t a, size_t b) { return in_rival[a] - in_best[a] > in_rival[b] - in_best[b]; });
  if (deciding.size() > kMostNamed) deciding.resize(kMostNamed);

  RuledOutPose out;
  out.T_model_part = rival.pose.T_model_part;
  out.why = motion_text(rival.pose.T_model_part * best.pose.T_model_part.inverse()) +
            text(", misfit %.0f more (%.0f decides):", rival.cost - best.cost, kSameCost);
  for (const size_t j : deciding) {
    const PlanePair here = *pair_of(best, j);
    const int id = input.model.planes[here.model].id;
    out.model_faces.push_back(id);
    out.why += text("%s face %d ", j == deciding.front() ? "" : ",", id);
    const PlanePair* there = pair_of(rival, j);
    if (!there) {
      out.why += "would have no place";
      continue;
    }
    const Vec3 r = plane_residual(
        observe(input.model.planes[there->model], input.measured.planes[there->measured], there->flipped),
        rival.pose.T_model_part);
    out.why += text("would lie on face %d, %.3f mm and %.2f mrad off", input.model.planes[there->model].id,
                    r[0], 1e3 * std::hypot(r[1], r[2]));
  }
  if (deciding.empty()) out.why += " no single face, but all together";
  std::sort(out.model_faces.begin(), out.model_faces.end());
  out.model_faces.erase(std::unique(out.model_faces.begin(), out.model_faces.end()), out.model_faces.end());
  return out;
}

RuledOutPose ruled_out_by_rays(const RigidTransform& T_model_part, const RayScore& rival,
                               const RigidTransform& T_model_part_best, const RayScore& best) {
  struct Tally {
    size_t rays = 0, against = 0;
  };
  std::map<int, Tally> by_face;
  for (size_t i = 0; i < best.sampled.size(); ++i) {
    const SampledRay &here = best.sampled[i], &there = rival.sampled[i];
    if (here.is_against || here.face < 0) continue;
    Tally& tally = by_face[here.face];
    ++tally.rays;
    tally.against += there.is_against;
  }
  std::vector<std::pair<int, Tally>> faces(by_face.begin(), by_face.end());
  // The share that a face's rays are against must not come from a ray or two.
  const auto strength = [](const Tally& t) {
    return static_cast<double>(t.against) / (static_cast<double>(t.rays) + 3);
  };
  std::stable_sort(faces.begin(), faces.end(),
                   [&](const auto& a, const auto& b) { return strength(a.second) > strength(b.second); });

  RuledOutPose out;
  out.T_model_part = T_model_part;
  out.why = motion_text(T_model_part * T_model_part_best.inverse()) +
            text(", %zu of %zu rays go through material or end in the air (%zu as chosen):", rival.against(),
                 rival.sampled.size(), best.against());
  for (const auto& [face, tally] : faces) {
    if (tally.against == 0 || out.model_faces.size() == kMostNamed ||
        strength(tally) < 0.3 * strength(faces.front().second))
      break;
    out.why += text("%s %zu of %zu on face %d", out.model_faces.empty() ? "" : ",", tally.against, tally.rays,
                    face + 1);
    out.model_faces.push_back(face + 1);
  }
  std::sort(out.model_faces.begin(), out.model_faces.end());
  return out;
}

}  // namespace tetragauge
