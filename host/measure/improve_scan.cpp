// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/measure/improve_scan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "host/measure/append_scan.hpp"

namespace tetragauge {
namespace {

class Improver {
 public:
  Improver(Link& link, const PlanningMachine& machine, const Solid& model, const RayCaster& caster,
           const Tolerances& tolerances, const ImproveOptions& options, const ScanOptions& scan,
           PartInProgress& part, MeasuringStory& story)
      : link_(link),
        machine_(machine),
        model_(model),
        caster_(caster),
        tolerances_(tolerances),
        options_(options),
        scan_options_(scan),
        part_(part),
        story_(story) {
    scan_options_.journal = nullptr;
  }

  std::optional<Error> run() {
    if (const auto status = link_.status())
      go_to(machine_, {1e-6 * status->table_udeg, 1e-3 * status->slide_um}, stance_);
    look_for_doubts();
    for (int round = 1; round <= options_.rounds; ++round) {
      if (rays_.rays.empty() && looks_.views.views.empty())
        return end("nothing is left in doubt that the machine could decide");
      const bool fits = keep_to_budget();
      if (!fits) return end("the time budget is used up");
      MeasuringRound& told = story_.rounds.emplace_back();
      told.before = count_doubts(part_.run, rays_);
      const std::optional<Error> error = measure(told);
      const bool inspected = told.points == 0 || inspect_again();
      look_for_doubts();
      told.after = count_doubts(part_.run, rays_);
      say(told);
      if (error) {
        // Without the device: an emulated one's has another name each time.
        const std::string device = link_.device() + ": ";
        story_.interruption =
            error->message.starts_with(device) ? error->message.substr(device.size()) : error->message;
        return error;
      }
      if (!inspected) return end("what a round added could not be inspected and was left out");
    }
    if (rays_.rays.empty() && looks_.views.views.empty())
      return end("nothing is left in doubt that the machine could decide");
    return end("as many rounds as asked for were made");
  }

 private:
  std::optional<Error> end(const char* why) {
    story_.end = why + what_remains();
    return std::nullopt;
  }

  // Of what is still in doubt, why no further ray was shot at it.
  std::string what_remains() const {
    const Doubts doubts = count_doubts(part_.run, rays_);
    if (doubts.doubtful == 0) return "";
    TetrahedronSum unreached{doubts.doubtful, doubts.doubtful_mm3};
    std::string out = "; " + sum(unreached) + " left in doubt";
    const char* separator = ": ";
    const auto say = [&](const TetrahedronSum& some, const char* what) {
      if (some.tetrahedra == 0) return;
      out += separator + sum(some) + what;
      separator = ", ";
    };
    for (const TetrahedronSum* part :
         {&rays_.open, &rays_.in_vain, &rays_.known, &rays_.in_noise, &rays_.not_looked_at}) {
      unreached.tetrahedra -= part->tetrahedra;
      unreached.volume_mm3 -= part->volume_mm3;
    }
    say(unreached, " that no direction reaches well enough");
    say(rays_.in_noise, " no thicker than noise makes them");
    say(rays_.known, " between points that further directions would only repeat");
    say(rays_.in_vain, " that directions reached and did not decide");
    say(rays_.not_looked_at, " smaller than the many that were looked at");
    say(rays_.open, " that more directions could decide");
    return out;
  }
  static std::string sum(const TetrahedronSum& some) {
    char mm3[40];
    std::snprintf(mm3, sizeof mm3, "%.1f", std::max(0.0, some.volume_mm3));
    return std::to_string(some.tetrahedra) + (some.tetrahedra == 1 ? " tetrahedron (" : " tetrahedra (") +
           mm3 + " mm3)";
  }

  double max_incidence_rad() const { return options_.plan.max_incidence_deg * std::numbers::pi / 180; }

  FaceLooksInput doubtful_faces() const {
    return {machine_,
            model_,
            caster_,
            T_part_model_,
            tolerances_,
            part_.run.inspection,
            options_.plan,
            part_.scan.points,
            part_.scan.header.u_cal_mm,
            looked_at_};
  }

  void look_for_doubts() {
    if (scan_options_.on_stage) scan_options_.on_stage("looking for what is in doubt");
    const SetUp& set_up = part_.run.set_ups.front();
    T_part_model_ = set_up.match.T_model_part.inverse();
    rays_ = rays_at_doubts(machine_, caster_, T_part_model_, set_up.reconstruction, max_incidence_rad(),
                           tried_, stance_);
    looks_ = looks_at_faces(doubtful_faces(), stance_);
  }

  // By the machine's own rules, not by its clock: a resent frame must not change the report.
  void add_time(MeasuringRound& told, double time_s) {
    told.machine_s += time_s;
    used_s_ += time_s;
  }
  double time_of_views_s() const {
    const auto time_s = plan_time_s(machine_, looks_.views, stance_);
    return time_s ? *time_s : 0;  // an error of the plan comes from run_scan()
  }
  double time_of_rays_s() const {
    MachineStance stance = stance_;
    double time_s = 0;
    for (size_t k = 0; k < rays_.rays.size(); ++k) time_s += time_of_ray_s(k, stance);
    return time_s;
  }
  double time_of_ray_s(size_t k, MachineStance& stance) const {
    const SingleRay& ray = rays_.rays[k];
    const StagePlace place{ray.table_deg, ray.slide_mm};
    double time_s = 0;
    const bool moves = k == 0 || rays_.rays[k - 1].table_deg != place.table_deg ||
                       rays_.rays[k - 1].slide_mm != place.slide_mm;
    if (moves)
      time_s += travel_time_s(machine_, stance, place) + 1e-6 * machine_.config.measure.stage_settle_us;
    go_to(machine_, place, stance);
    const int32_t step = std::max(std::abs(ray.a_urad - stance.a_urad), std::abs(ray.b_urad - stance.b_urad));
    stance.a_urad = ray.a_urad;
    stance.b_urad = ray.b_urad;
    return time_s + ray_time_s(machine_, options_.plan.samples, step);
  }

  // Faces before tetrahedra; of these as many as fit. False: nothing does.
  bool keep_to_budget() {
    if (!(options_.budget_s > 0)) return true;
    const double left_s = options_.budget_s - used_s_;
    if (time_of_views_s() > left_s) looks_ = {};
    double time_s = time_of_views_s();
    MachineStance stance = stance_;
    size_t count = 0;
    while (count < rays_.rays.size() && (time_s += time_of_ray_s(count, stance)) <= left_s) ++count;
    rays_.rays.resize(count);
    rays_.tried.resize(count);
    return count > 0 || !looks_.views.views.empty();
  }

  std::optional<Error> take(Result<MeasuredScan> measured, const ScanPlan* rasters, MeasuringRound& told) {
    if (!measured) return measured.error();
    if (rasters) drop_cut_spots(doubtful_faces(), *rasters, measured->scan);
    append_scan(part_.scan, measured->scan, part_.views);
    add_counts(part_.counts, measured->counts);
    told.points += measured->scan.size();
    return std::nullopt;
  }

  std::optional<Error> measure(MeasuringRound& told) {
    whole_before_ = part_.scan;
    if (!looks_.views.views.empty()) {
      if (const auto error = take(run_scan(link_, looks_.views, scan_options_), &looks_.views, told))
        return error;
      told.views = looks_.views.views.size();
      add_time(told, time_of_views_s());
      part_.views += static_cast<uint32_t>(told.views);
      const PlannedView& last = looks_.views.views.back();
      go_to(machine_, {last.table_deg, last.slide_mm}, stance_);
      for (const int face : looks_.uncovered) ++looked_at_[face];
      for (const int face : looks_.undecided) ++looked_at_[face];
    }
    if (!rays_.rays.empty()) {
      if (const auto error =
              take(measure_rays(link_, rays_.rays, options_.plan.samples, scan_options_), nullptr, told))
        return error;
      told.rays = rays_.rays.size();
      add_time(told, time_of_rays_s());
      part_.views += static_cast<uint32_t>(places_of(rays_.rays));
      for (TriedRay& ray : rays_.tried) {
        ray.round = static_cast<int>(story_.rounds.size());
        tried_.push_back(ray);
      }
      go_to(machine_, tried_.back().place, stance_);
    }
    return std::nullopt;
  }

  // Each is one view of the scan.
  static size_t places_of(std::span<const SingleRay> rays) {
    size_t places = 0;
    for (size_t k = 0; k < rays.size(); ++k)
      places +=
          k == 0 || rays[k].table_deg != rays[k - 1].table_deg || rays[k].slide_mm != rays[k - 1].slide_mm;
    return places;
  }

  // Points that spoil what was known are left out again.
  bool inspect_again() {
    Result<InspectionRun> run = inspect(part_.scan, model_, tolerances_, options_.inspect);
    if (!run) {
      part_.scan = std::move(whole_before_);
      return false;
    }
    part_.run = std::move(*run);
    return true;
  }

  void say(const MeasuringRound& told) const {
    if (!scan_options_.log) return;
    const auto from_to = [](size_t before, size_t after) {
      return std::to_string(before) + " -> " + std::to_string(after);
    };
    scan_options_.log("round " + std::to_string(story_.rounds.size()) + ": " + std::to_string(told.rays) +
                      " directions and " + std::to_string(told.views) +
                      " views; tetrahedra a ray could decide " +
                      from_to(told.before.resolvable, told.after.resolvable) + ", faces undecided " +
                      from_to(told.before.undecided, told.after.undecided) + ", not measured " +
                      from_to(told.before.not_measured, told.after.not_measured));
  }

  Link& link_;
  const PlanningMachine& machine_;
  const Solid& model_;
  const RayCaster& caster_;
  const Tolerances& tolerances_;
  const ImproveOptions& options_;
  ScanOptions scan_options_;
  PartInProgress& part_;
  MeasuringStory& story_;

  RigidTransform T_part_model_;
  DoubtRays rays_;
  FaceLooks looks_;
  std::vector<TriedRay> tried_;
  std::map<int, int> looked_at_;
  MachineStance stance_;
  Scan whole_before_;
  double used_s_ = 0;
};

}  // namespace

std::optional<Error> improve_scan(Link& link, const PlanningMachine& machine, const Solid& model,
                                  const RayCaster& caster, const Tolerances& tolerances,
                                  const ImproveOptions& options, const ScanOptions& scan,
                                  PartInProgress& part, MeasuringStory& story) {
  return Improver(link, machine, model, caster, tolerances, options, scan, part, story).run();
}

}  // namespace tetragauge
