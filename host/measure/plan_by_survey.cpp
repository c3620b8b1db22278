// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/measure/plan_by_survey.hpp"

#include <cmath>
#include <cstdio>

#include "host/plan/face_patches.hpp"

namespace tetragauge {
namespace {

// The survey may be too coarse to know the part by: then it is looked at from all round, still quickly.
constexpr double kSecondPitch_mm = 2;
constexpr uint32_t kSecondSamples = 8;
// Views and windows stay right when the part stands so far from where it is thought.
constexpr double kAlike_mm = 0.5;
constexpr double kAlikeShare = 0.99;

struct Pose {
  bool is_known = false;
  RigidTransform T_part_model;
  std::string why_not;
};

// Turned or shifted along a direction that the data leave open.
RigidTransform moved_along(const FreeDirection& free, double by) {
  if (free.kind == FreeDirection::Kind::translation) return {Mat3::Identity(), by * free.axis};
  const Mat3 turn = Eigen::AngleAxisd(by, free.axis).toRotationMatrix();
  return {turn, free.point_mm - turn * free.point_mm};
}

Pose find_pose(const Scan& scan, const Solid& model, const RayCaster& caster, const InspectOptions& options,
               const ScanOptions& session) {
  if (session.on_stage) session.on_stage("finding the part's pose");
  const Result<Reconstruction> reconstruction = reconstruct(scan, options.reconstruct);
  if (!reconstruction) return {false, {}, reconstruction.error().message};
  const Result<MeasuredFaces> faces = find_faces(scan, *reconstruction, options.faces);
  if (!faces) return {false, {}, faces.error().message};
  const Result<Match> match = match_scan(model, caster, scan, *faces, options.match);
  if (!match) return {false, {}, match.error().message};
  for (const EquivalentPose& other : match->equivalents) {
    if (!stands_alike(model, caster, match->T_model_part, other.T_model_part))
      return {false, {}, std::to_string(match->equivalents.size() + 1) + " poses fit what it saw"};
  }
  for (const FreeDirection& free : match->undetermined) {
    const bool turns = free.kind == FreeDirection::Kind::rotation;
    // Far enough that nothing but a symmetry looks alike.
    if (!stands_alike(model, caster, match->T_model_part,
                      moved_along(free, turns ? 0.5 : 5.0) * match->T_model_part))
      return {false, {}, std::string("it leaves a ") + (turns ? "rotation" : "shift") + " of the part open"};
  }
  return {true, match->T_model_part.inverse(), ""};
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

}  // namespace

bool stands_alike(const Solid& model, const RayCaster& caster, const RigidTransform& T_model_part_a,
                  const RigidTransform& T_model_part_b) {
  const RigidTransform T_b_a = T_model_part_b * T_model_part_a.inverse();
  size_t spots = 0, alike = 0;
  for (const Patch& patch : face_patches(model, caster)) {
    if (!(patch.area_mm2 > 0)) continue;
    const Vec3 normal = T_b_a.R * patch.normal;
    const auto hit = caster.first_hit(T_b_a * patch.point_mm + kAlike_mm * normal, -normal);
    ++spots;
    alike += hit && hit->distance_mm <= 2 * kAlike_mm && hit->normal.dot(normal) > 0.5;
  }
  return static_cast<double>(alike) >= kAlikeShare * static_cast<double>(spots);
}

Result<SurveyedPlan> plan_by_survey(Link& link, const PlanningMachine& machine, const Solid& model,
                                    const RayCaster& caster, const InspectOptions& inspect,
                                    const PlanPartOptions& options, const ScanOptions& scan) {
  SurveyedPlan out;
  const auto survey = survey_volume(link, scan);
  if (!survey) return survey.error();
  out.machine_s = survey->counts.machine_time_s;
  Pose pose = find_pose(survey->scan, model, caster, inspect, scan);
  if (!pose.is_known) {
    if (scan.log) scan.log("the survey does not say how the part stands: a second, finer one");
    ScanOptions quick = scan;
    quick.keep_table = false;
    quick.journal = nullptr;
    const auto second = run_scan(
        link, plan_around(machine.head, survey->scan.points, {kSecondPitch_mm, kSecondSamples}), quick);
    if (!second) return second.error();
    out.machine_s += second->counts.machine_time_s;
    pose = find_pose(second->scan, model, caster, inspect, scan);
  }
  if (pose.is_known) {
    MachineStance stance = homed_stance(machine);
    const auto status = link.status();
    if (!status) return status.error();
    go_to(machine, {1e-6 * status->table_udeg, 1e-3 * status->slide_um}, stance);
    if (scan.on_stage) scan.on_stage("planning the views");
    const auto plan = plan_part(machine, model, caster, pose.T_part_model, options, stance);
    if (plan) {
      out.scan = plan->scan;
      char time[40];
      std::snprintf(time, sizeof time, "%.0f s predicted", plan->time_s);
      out.how = "the pose found by a coarse scan: " + std::to_string(plan->scan.views.size()) +
                " views from " + std::to_string(plan->places) + " places, " + time;
      return out;
    }
    pose.why_not = plan.error().message;
  }
  out.scan = plan_around(machine.head, survey->scan.points, {options.pitch_mm, options.samples});
  out.how = "views all round the part, because a coarse scan does not tell its pose (" +
            first_line(pose.why_not) + ")";
  return out;
}

}  // namespace tetragauge
