// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "host/measure/doubts.hpp"
#include "host/measure/volume_noise.hpp"
#include "host/plan/order_views.hpp"
#include "host/plan/survey_sights.hpp"

namespace tetragauge {
namespace {

// A vote fades within three sigma of its point (reconstruct/vote_visibility.hpp): a shorter way through a
// tetrahedron is within the noise, whatever the ray finds.
constexpr double kVoteSigmas = 3;
// The ray must come from the side that the tetrahedron wants to be looked at from.
constexpr double kLeastCosine = 0.17;  // 80 degrees
// Three sigma on either side of nothing: a tetrahedron whose volume is less comes and goes with the noise of
// its own corners, and each new point draws others like it.
constexpr double kNoiseSigmas = 2 * kVoteSigmas;
// Seen again: from the same place within a tenth of a turn, at the same spot within half a spacing.
constexpr double kSamePlace_deg = 36, kSamePlace_mm = 60, kSameSpotSpacings = 0.5;
// A corner of a part has three sides to be asked from. What rays of as many rounds within a spacing, which is
// as fine as the averaged points can tell, have left in doubt is not a matter of one more ray.
constexpr size_t kMostAsked = 3;
// In one round; largest volume first.
constexpr size_t kMostTetrahedra = 1500;

// A tetrahedron in doubt and where to aim in it, model frame.
struct Target {
  std::array<Vec3, 4> corners;
  std::array<Vec3, 4> rays;  // mean directions that the corners were measured along; zero: was not measured
  std::array<double, 4> sigma_mm{};  // along them
  Vec3 look_from = Vec3::Zero();
  std::vector<Vec3> aims;
  double volume_mm3 = 0;
};

struct Way {
  double in_mm = 0, out_mm = 0;
};

// Of a ray through a positively oriented tetrahedron: the part of it that lies on the inner side of all four
// planes.
std::optional<Way> way_through(const std::array<Vec3, 4>& v, const MachineRay& ray) {
  static constexpr int kFacet[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  Way way{0, 1e9};
  for (int i = 0; i < 4; ++i) {
    const Vec3& a = v[static_cast<size_t>(kFacet[i][0])];
    Vec3 normal = (v[static_cast<size_t>(kFacet[i][1])] - a).cross(v[static_cast<size_t>(kFacet[i][2])] - a);
    if (normal.dot(v[static_cast<size_t>(i)] - a) > 0) normal = -normal;  // outwards
    const double speed = normal.dot(ray.direction), height = normal.dot(ray.origin_mm - a);
    if (std::abs(speed) < 1e-12 * normal.norm()) {
      if (height > 0) return std::nullopt;
    } else if (speed > 0) {
      way.out_mm = std::min(way.out_mm, -height / speed);
    } else {
      way.in_mm = std::max(way.in_mm, -height / speed);
    }
  }
  if (!(way.in_mm < way.out_mm)) return std::nullopt;
  return way;
}

double median_sigma(const Reconstruction& reconstruction) {
  std::vector<float> sigmas = reconstruction.vertex_sigma_mm;
  if (sigmas.empty()) return 0;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return static_cast<double>(*middle);
}

bool noise_can_make(const Reconstruction& reconstruction, const DoubtfulTetrahedron& doubt) {
  std::array<NoisyCorner, 4> corners;
  for (size_t i = 0; i < 4; ++i) {
    const uint32_t v = reconstruction.cells[doubt.cell].vertex[i];
    corners[i] = {reconstruction.vertices[v], reconstruction.vertex_ray[v],
                  static_cast<double>(reconstruction.vertex_sigma_mm[v])};
  }
  return doubt.volume_mm3 < kNoiseSigmas * volume_sigma_mm3(corners);
}

// Those that noise alone can make are counted in `out`.
std::vector<Target> targets_of(const Reconstruction& reconstruction, const RigidTransform& T_model_part,
                               double least_way_mm, DoubtRays& out) {
  std::vector<Target> targets;
  for (const DoubtfulTetrahedron& doubt : reconstruction.doubtful_ranked) {
    const LabelledTetrahedron& cell = reconstruction.cells[doubt.cell];
    Target target;
    double longest = 0;
    for (size_t i = 0; i < 4; ++i) {
      target.corners[i] = T_model_part * reconstruction.vertices[cell.vertex[i]];
      target.rays[i] = T_model_part.R * reconstruction.vertex_ray[cell.vertex[i]];
      target.sigma_mm[i] = static_cast<double>(reconstruction.vertex_sigma_mm[cell.vertex[i]]);
      for (size_t k = 0; k < i; ++k)
        longest = std::max(longest, (target.corners[i] - target.corners[k]).norm());
    }
    if (longest < least_way_mm || noise_can_make(reconstruction, doubt)) {
      out.in_noise.add(doubt.volume_mm3);
      continue;
    }
    if (targets.size() == kMostTetrahedra) {
      out.not_looked_at.add(doubt.volume_mm3);
      continue;
    }
    target.look_from = T_model_part.R * doubt.look_from;
    target.volume_mm3 = doubt.volume_mm3;
    const Vec3 middle = T_model_part * doubt.centroid_mm;
    target.aims.push_back(middle);
    // One ray says little about a large one.
    if (longest > 4 * reconstruction.vertex_spacing_mm)
      for (const Vec3& corner : target.corners) target.aims.push_back(0.5 * (middle + corner));
    targets.push_back(std::move(target));
  }
  return targets;
}

// A ray that is to end where a corner within a spacing was measured, on the same face, would be averaged with
// what is there: it says again what that corner's rays have said.
bool says_again(const Target& target, const RayHit& hit, double spacing_mm) {
  for (size_t i = 0; i < 4; ++i) {
    const Vec3 aside = target.corners[i] - hit.point_mm;
    const double along = std::abs(hit.normal.dot(target.rays[i]));
    if (hit.normal.dot(target.rays[i]) < 0 && aside.norm() <= spacing_mm &&
        std::abs(hit.normal.dot(aside)) <= kVoteSigmas * target.sigma_mm[i] * along)
      return true;
  }
  return false;
}

struct Shot {
  uint32_t target = 0;
  Vec3 at_mm = Vec3::Zero();  // part frame
  MirrorAim aim;
};

// From about the same place at about the same spot.
bool was_tried(const StagePlace& place, const Vec3& at_mm, std::span<const TriedRay> tried, double same_mm) {
  return std::any_of(tried.begin(), tried.end(), [&](const TriedRay& ray) {
    return (ray.at_mm - at_mm).norm() <= same_mm &&
           std::abs(std::remainder(ray.place.table_deg - place.table_deg, 360.0)) <= kSamePlace_deg &&
           std::abs(ray.place.slide_mm - place.slide_mm) <= kSamePlace_mm;
  });
}

// In as many rounds as it is worth, rays were aimed within a spacing of where it would be aimed at.
bool was_asked_enough(const std::vector<Vec3>& aims_part_mm, std::span<const TriedRay> tried,
                      double spacing_mm) {
  std::set<int> rounds;
  for (const TriedRay& ray : tried)
    for (const Vec3& at : aims_part_mm)
      if ((ray.at_mm - at).norm() <= spacing_mm) rounds.insert(ray.round);
  return rounds.size() >= kMostAsked;
}

}  // namespace

DoubtRays rays_at_doubts(const PlanningMachine& machine, const RayCaster& caster,
                         const RigidTransform& T_part_model, const Reconstruction& reconstruction,
                         double max_incidence_rad, std::span<const TriedRay> tried,
                         const MachineStance& stance) {
  const RigidTransform T_model_part = T_part_model.inverse();
  const double open_mm = kVoteSigmas * median_sigma(reconstruction);
  DoubtRays out;
  const std::vector<Target> targets = targets_of(reconstruction, T_model_part, 2 * open_mm, out);
  double low_mm = 1e9, high_mm = -1e9;
  for (const Vec3& vertex : reconstruction.vertices) {
    low_mm = std::min(low_mm, vertex.z());
    high_mm = std::max(high_mm, vertex.z());
  }
  const std::vector<StagePlace> places = places_worth_trying(machine, low_mm, high_mm);
  const double same_mm = kSameSpotSpacings * reconstruction.vertex_spacing_mm;

  std::vector<uint8_t> asked(targets.size());
  tbb::parallel_for(size_t{0}, targets.size(), [&](size_t k) {
    std::vector<Vec3> aims;
    for (const Vec3& at : targets[k].aims) aims.push_back(T_part_model * at);
    asked[k] = was_asked_enough(aims, tried, reconstruction.vertex_spacing_mm);
  });

  std::vector<std::vector<Shot>> shots(places.size());
  // Targets that a ray reaches, but one was tried, or would say again what is known.
  std::vector<std::vector<uint32_t>> seen_again(places.size()), known(places.size());
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t p) {
    const HeadOverPart head(machine, T_part_model, places[p]);
    const Vec3 mirror = head.beam(0, 0).origin_mm;
    for (uint32_t k = 0; k < targets.size(); ++k) {
      const Target& target = targets[k];
      if (target.look_from.dot((mirror - target.aims.front()).normalized()) < kLeastCosine) continue;
      for (const Vec3& at : target.aims) {
        // First with a ray that leaves a few millimetres beside the true one: most fail here.
        const auto about = way_through(target.corners, {mirror, (at - mirror).normalized()});
        if (!about || about->out_mm - about->in_mm < open_mm) continue;
        const auto aim = head.aim(at);
        if (!aim) continue;
        const MachineRay ray = head.beam(aim->a_urad, aim->b_urad);
        const auto way = way_through(target.corners, ray);
        if (!way || way->out_mm - way->in_mm < 2 * open_mm) continue;
        const auto hit = caster.first_hit(ray.origin_mm, ray.direction);
        // A ray that ends on its near side touches it; one that ends before says nothing.
        if (!hit || hit->distance_mm < way->in_mm - open_mm) continue;
        const SpotSight sight = head.look_along(caster, ray, *hit);
        if (!sight.within(max_incidence_rad) || sight.cameras < 2) continue;
        if (!head.is_clear(caster, ray, *hit)) continue;
        const Vec3 at_part = T_part_model * at;
        const bool goes_through = hit->distance_mm > way->out_mm + open_mm;
        if (!goes_through && says_again(target, *hit, reconstruction.vertex_spacing_mm)) {
          known[p].push_back(k);
          continue;
        }
        if (asked[k] || was_tried(places[p], at_part, tried, same_mm))
          seen_again[p].push_back(k);
        else
          shots[p].push_back({k, at_part, *aim});
      }
    }
  });

  // Places by what they add per second, until every tetrahedron that can be shot at is.
  std::vector<bool> open(targets.size(), true);
  std::vector<size_t> used;
  const double place_s = travel_time_s(machine, {}, {90, 0});
  const double ray_s = ray_time_s(machine, PlannedView{}.samples, machine.head.mirror_limit_urad / 8);
  for (;;) {
    double best = 0;
    size_t best_place = 0;
    for (size_t p = 0; p < places.size(); ++p) {
      double volume = 0, time = place_s;
      uint32_t last = ~uint32_t{0};
      for (const Shot& shot : shots[p]) {
        if (!open[shot.target]) continue;
        if (shot.target != last) volume += targets[shot.target].volume_mm3;
        last = shot.target;
        time += ray_s;
      }
      if (volume / time > best) {
        best = volume / time;
        best_place = p;
      }
    }
    if (!(best > 0)) break;
    std::vector<Shot> taken;
    for (const Shot& shot : shots[best_place])
      if (open[shot.target]) taken.push_back(shot);
    for (const Shot& shot : taken) {
      if (open[shot.target]) out.open.add(targets[shot.target].volume_mm3);
      open[shot.target] = false;
    }
    shots[best_place] = std::move(taken);
    used.push_back(best_place);
  }

  const auto add_left = [&](const std::vector<std::vector<uint32_t>>& lists, TetrahedronSum& sum) {
    for (const std::vector<uint32_t>& here : lists)
      for (const uint32_t k : here) {
        if (open[k]) sum.add(targets[k].volume_mm3);
        open[k] = false;
      }
  };
  add_left(seen_again, out.in_vain);
  add_left(known, out.known);

  std::vector<StagePlace> way;
  for (const size_t p : used) way.push_back(places[p]);
  for (const size_t k : order_views(machine, way, stance)) {
    std::vector<Shot>& here = shots[used[k]];
    // Row by row, so that the mirrors turn little.
    std::stable_sort(here.begin(), here.end(), [](const Shot& s, const Shot& t) {
      return std::pair(s.aim.b_urad, s.aim.a_urad) < std::pair(t.aim.b_urad, t.aim.a_urad);
    });
    for (const Shot& shot : here) {
      out.rays.push_back({way[k].table_deg, way[k].slide_mm, shot.aim.a_urad, shot.aim.b_urad});
      out.tried.push_back({way[k], shot.at_mm, 0});
    }
  }
  return out;
}

Doubts count_doubts(const InspectionRun& run, const DoubtRays& open) {
  Doubts doubts;
  const Reconstruction& reconstruction = run.set_ups.front().reconstruction;
  doubts.doubtful = reconstruction.doubtful;
  for (const DoubtfulTetrahedron& doubt : reconstruction.doubtful_ranked)
    doubts.doubtful_mm3 += doubt.volume_mm3;
  doubts.resolvable = open.open.tetrahedra;
  doubts.resolvable_mm3 = open.open.volume_mm3;
  for (const FaceInspection& face : run.inspection.faces) {
    doubts.undecided += face.verdict == Verdict::undecided;
    doubts.not_measured +=
        face.verdict == Verdict::not_measured || (face.verdict == Verdict::none && !face.measured);
  }
  return doubts;
}

}  // namespace tetragauge
