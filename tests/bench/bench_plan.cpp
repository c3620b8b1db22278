// SPDX-License-Identifier: GPL-3.0-or-later
// The planner against the fixed views all round the part: the machine's time, points and coverage of every
// face; its time and its unseen faces against what the machine then finds.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "host/inspect/cast_scan.hpp"
#include "host/inspect/point_grid.hpp"
#include "host/plan/place_on_table.hpp"
#include "host/solid/face_outline.hpp"
#include "tests/bench/machine_bench.hpp"

namespace tetragauge::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// Light from both sides of an edge makes points that lie nowhere.
constexpr double kEdge_mm = 0.3;
constexpr double kCover_mm = 2.5;  // near a point of a raster of 1 mm on a face at 65 degrees

// What a scan has of one face, by the true pose.
struct FaceFound {
  size_t points = 0;   // away from its edges
  size_t well = 0;     // of all, met within the largest incidence
  double covered = 0;  // share of what can be seen of it that lies near one of these
};

std::vector<FaceFound> find(const Scan& scan, const Solid& model, const RayCaster& caster,
                            const RigidTransform& T_model_part, double max_incidence_deg,
                            const std::vector<bool>& visible, const std::vector<Patch>& patches) {
  const CastScan cast = cast_scan(scan, model, caster, T_model_part);
  std::vector<std::vector<Vec3>> edges, well(model.faces().size());
  for (const FaceOutline& outline : face_outlines(model)) edges.push_back(samples_along(outline, 0.2));
  std::vector<PointGrid> near_edge;
  for (const auto& points : edges) near_edge.emplace_back(points, kEdge_mm);
  std::vector<FaceFound> found(model.faces().size());
  for (size_t i = 0; i < scan.size(); ++i) {
    if (cast.face[i] < 0 || std::abs(cast.deviation_mm[i]) > 5 * cast.sigma_mm[i]) continue;
    const auto face = static_cast<size_t>(cast.face[i]);
    found[face].points += !near_edge[face].any_within(cast.hit_mm[i], kEdge_mm);
    const Vec3 direction = (cast.points_mm[i] - T_model_part * scan.ray_origins[i]).normalized();
    const auto hit = caster.first_hit(T_model_part * scan.ray_origins[i], direction);
    if (!hit || std::acos(std::min(1.0, -hit->normal.dot(direction))) > max_incidence_deg * kDegree) continue;
    ++found[face].well;
    well[face].push_back(cast.hit_mm[i]);
  }
  std::vector<double> whole(found.size(), 0.0);
  std::vector<PointGrid> near_point;
  for (const auto& points : well) near_point.emplace_back(points, kCover_mm);
  for (size_t k = 0; k < patches.size(); ++k) {
    if (!visible[k]) continue;
    const auto face = static_cast<size_t>(patches[k].face);
    whole[face] += patches[k].area_mm2;
    if (near_point[face].any_within(patches[k].point_mm, kCover_mm))
      found[face].covered += patches[k].area_mm2;
  }
  for (size_t f = 0; f < found.size(); ++f) found[f].covered = whole[f] > 0 ? found[f].covered / whole[f] : 1;
  return found;
}

struct Line {
  bool is_good = true;
  double ratio = 0;
};

Line bench_part(const MachinePart& part, const BenchOptions& options) {
  BenchMachine bench = start_machine({.csg = part.good, .place = part.place, .faults = ""});
  const Solid model = solid_of(part.good);
  const RayCaster caster(model);
  const RigidTransform place = part.place.empty() ? RigidTransform{} : *parse_pose(part.place, "place");
  const RigidTransform T_part_model = place_on_table(model, place);
  const auto machine = read_machine(*bench.link);
  PlanPartOptions planning;
  planning.points_per_face = options.points;
  const auto plan = plan_part(*machine, model, caster, T_part_model, planning);
  if (!plan) {
    std::printf("%-25s %s\n", part.name.c_str(), plan.error().message.c_str());
    return {false, 0};
  }
  const auto planned = run_scan(*bench.link, plan->scan);
  const auto fixed_plan = default_plan(*bench.link, {planning.pitch_mm, planning.samples});
  const auto fixed = fixed_plan ? run_scan(*bench.link, *fixed_plan) : fixed_plan.error();
  if (!planned || !fixed) {
    std::printf("%-25s %s\n", part.name.c_str(), (planned ? fixed : planned).error().message.c_str());
    return {false, 0};
  }

  const RigidTransform T_model_part = T_part_model.inverse();
  const std::vector<Patch> patches = face_patches(model, caster);
  const SightSurvey survey =
      survey_sights(*machine, caster, T_part_model, patches, planning.max_incidence_deg * kDegree);
  std::vector<bool> visible(patches.size());
  for (size_t k = 0; k < patches.size(); ++k) visible[k] = survey.outlooks[k].is_seen_well;
  // Half a degree for the noise of the point that the angle is taken at.
  const double limit = planning.max_incidence_deg + 0.5;
  const auto by_plan = find(planned->scan, model, caster, T_model_part, limit, visible, patches);
  const auto by_fixed = find(fixed->scan, model, caster, T_model_part, limit, visible, patches);

  size_t least = ~size_t{0}, unseen = 0, wrong = 0;
  double covered_plan = 1, covered_fixed = 1;
  for (size_t f = 0; f < plan->faces.size(); ++f) {
    const FaceOutlook& face = plan->faces[f];
    if (face.is_seen) {
      least = std::min(least, by_plan[f].well);
      covered_plan = std::min(covered_plan, by_plan[f].covered);
      covered_fixed = std::min(covered_fixed, by_fixed[f].covered);
      continue;
    }
    ++unseen;
    const bool is_found = face.obstacle == Obstacle::none ? by_plan[f].well + by_fixed[f].well > 0
                                                          : by_plan[f].points + by_fixed[f].points > 0;
    wrong += is_found;
    if (is_found)
      std::fprintf(stderr, "%s: face %d (%s): %zu + %zu points, %zu + %zu well\n", part.name.c_str(), face.id,
                   face.why.c_str(), by_plan[f].points, by_fixed[f].points, by_plan[f].well,
                   by_fixed[f].well);
  }
  const double time = planned->counts.machine_time_s, fixed_time = fixed->counts.machine_time_s;
  std::printf("%-25s %5zu %6zu %5zu %5zu %6zu %8.0f %7.0f %7.0f %6.1f %7zu %6.0f%% %6.0f%%\n",
              part.name.c_str(), plan->faces.size(), unseen, wrong, plan->places, plan->scan.views.size(),
              plan->time_s, time, fixed_time, fixed_time / time, least, 100 * covered_plan,
              100 * covered_fixed);
  std::fflush(stdout);
  const bool is_good = wrong == 0 && least >= options.points && std::abs(plan->time_s / time - 1) <= 0.1 &&
                       covered_plan >= std::min(0.98, covered_fixed) && fixed_time >= 2 * time;
  return {is_good, fixed_time / time};
}

}  // namespace

int bench_plan(const BenchOptions& options) {
  std::printf("%-25s %5s %6s %5s %5s %6s %8s %7s %7s %6s %7s %7s %7s\n", "part", "faces", "unseen", "wrong",
              "places", "views", "pred. s", "plan s", "fixed s", "ratio", "points", "cover", "fixed");
  bool is_good = true;
  for (const MachinePart& part : machine_parts())
    if (is_chosen(options, part)) is_good = bench_part(part, options).is_good && is_good;
  std::printf(
      "wrong: unseen faces that were seen after all; points: of the face with the fewest; cover: of the "
      "visible "
      "area of the\nface with the least, by the plan and by the fixed views\n");
  return is_good ? 0 : 1;
}

}  // namespace tetragauge::bench
