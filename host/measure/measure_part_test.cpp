// SPDX-License-Identifier: GPL-3.0-or-later
// The main job on the emulated machine, at a coarse pitch: rounds, their limits, and what happens when one
// breaks off.
#include "host/measure/measure_part.hpp"

#include <signal.h>

#include <regex>

#include "host/measure/append_scan.hpp"
#include "host/plan/test_parts.hpp"
#include "host/report/report.hpp"

namespace tetragauge {
namespace {

// An L with a slot: no symmetry.
const char* const kPart =
    "difference() { cube(size = [60, 50, 40], center = false);\n"
    "multmatrix([[1, 0, 0, 34], [0, 1, 0, -1], [0, 0, 1, 22], [0, 0, 0, 1]]) { cube(size = [27, 52, 19], "
    "center = "
    "false); }\n"
    "multmatrix([[1, 0, 0, -1], [0, 1, 0, 14], [0, 0, 1, 12], [0, 0, 0, 1]]) { cube(size = [30, 9, 29], "
    "center = "
    "false); } }\n";
const char* const kCube = "cube(size = [40, 40, 40], center = false);\n";

struct Bench {
  EmulatedSession session;
  Solid model;
};

Bench bench_of(const char* csg, uint64_t seed = 1) {
  const auto file = temporary_file("measured.csg", csg);
  auto session = start_session({.part = file, .seed = seed});
  EXPECT_TRUE(session) << session.error().message;
  auto model = read_solid(file);
  EXPECT_TRUE(model) << model.error().message;
  return {std::move(*session), std::move(*model)};
}

MeasureOptions quick(int rounds) {
  MeasureOptions options;
  options.improve.plan.pitch_mm = 2;
  options.improve.plan.samples = 16;
  options.improve.rounds = rounds;
  return options;
}

Tolerances profile(double mm) {
  Tolerances tolerances;
  tolerances.given = true;
  tolerances.by_default.profile_mm = mm;
  return tolerances;
}

// What is left, and of it what for which reason: the reasons cover all of it.
void expect_every_doubt_has_its_reason(const MeasuringStory& story) {
  static const std::regex amount(R"((\d+) tetrahedr(?:on|a) \((\d+\.\d) mm3\))");
  std::vector<std::pair<size_t, double>> amounts;
  for (std::sregex_iterator it(story.end.begin(), story.end.end(), amount), last; it != last; ++it)
    amounts.emplace_back(std::stoul((*it)[1]), std::stod((*it)[2]));
  ASSERT_GE(amounts.size(), 2u) << story.end;
  const Doubts& after = story.rounds.back().after;
  EXPECT_EQ(amounts[0].first, after.doubtful);
  EXPECT_NEAR(amounts[0].second, after.doubtful_mm3, 0.051);
  size_t tetrahedra = 0;
  double volume_mm3 = 0;
  for (size_t k = 1; k < amounts.size(); ++k) {
    tetrahedra += amounts[k].first;
    volume_mm3 += amounts[k].second;
  }
  EXPECT_EQ(tetrahedra, amounts[0].first) << story.end;
  EXPECT_NEAR(volume_mm3, amounts[0].second, 0.051 * static_cast<double>(amounts.size())) << story.end;
}

TEST(MeasurePart, EndsWithNothingThatARayCouldDecide) {
  const Bench bench = bench_of(kPart);
  const auto part = measure_part(*bench.session.link, bench.model, profile(0.3), quick(15));
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_FALSE(part->interruption);
  ASSERT_FALSE(part->story.rounds.empty());
  EXPECT_TRUE(part->story.end.starts_with("nothing is left in doubt that the machine could decide"))
      << part->story.end;
  expect_every_doubt_has_its_reason(part->story);
  size_t rays = 0, points = 0;
  for (const MeasuringRound& round : part->story.rounds) {
    rays += round.rays;
    points += round.views == 0 ? round.points : 0;
    EXPECT_GT(round.machine_s, 0);
    if (round.views > 0) continue;
    // The machine is the judge of what is legal: nearly every direction gives its point.
    EXPECT_GE(static_cast<double>(round.points), 0.9 * static_cast<double>(round.rays) - 1);
  }
  EXPECT_GT(rays, 0u);
  EXPECT_GT(points, 0u);
  EXPECT_GT(part->story.rounds.front().before.resolvable, 0u);
  EXPECT_EQ(part->story.rounds.back().after.resolvable, 0u);
  EXPECT_EQ(part->run.inspection.faces.size(), bench.model.faces().size());
  EXPECT_EQ(part->scan.size(), part->run.set_ups.front().reconstruction.point_vertex.size());
  // Views are numbered on: a point's view says from where it was measured.
  EXPECT_TRUE(std::is_sorted(part->scan.view.begin(), part->scan.view.end()));
}

TEST(MeasurePart, WithoutRoundsIsTheScanInspected) {
  const Bench bench = bench_of(kPart);
  auto options = quick(0);
  options.plan = plan_all_round(2, 16);
  const auto part = measure_part(*bench.session.link, bench.model, profile(0.3), options);
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_TRUE(part->story.rounds.empty());
  EXPECT_EQ(part->story.plan, "as given");
  const auto scan = run_scan(*bench.session.link, *options.plan);
  ASSERT_TRUE(scan) << scan.error().message;
  EXPECT_EQ(part->scan.points, scan->scan.points);
}

TEST(MeasurePart, KeepsToItsBudget) {
  const Bench bench = bench_of(kPart);
  auto options = quick(15);
  options.improve.budget_s = 8;
  const auto part = measure_part(*bench.session.link, bench.model, profile(0.3), options);
  ASSERT_TRUE(part) << part.error().message;
  double time_s = 0;
  for (const MeasuringRound& round : part->story.rounds) time_s += round.machine_s;
  EXPECT_GT(time_s, 0);
  EXPECT_LE(time_s, 8);
  EXPECT_TRUE(part->story.end.starts_with("the time budget is used up")) << part->story.end;
}

const FaceInspection& face_of(const PartMeasurement& part, int id) {
  return part.run.inspection.faces[static_cast<size_t>(id) - 1];
}

// Orientation rests on the datum's points as much as on the face's own: both get more.
TEST(MeasurePart, GoesBackToAFaceUndecidedAgainstItsDatum) {
  int datum = 0, wall = 0;
  Tolerances tolerances;
  tolerances.given = true;
  const auto measure = [&](double angularity_mrad, int rounds) {
    const Bench bench = bench_of(kPart);
    for (const Face& face : bench.model.faces()) {
      if ((face.normal - Vec3(0, -1, 0)).norm() < 1e-9 && std::abs(face.d_mm) < 1e-9) datum = face.id;
      if ((face.normal - Vec3(-1, 0, 0)).norm() < 1e-9 && std::abs(face.d_mm) < 1e-9) wall = face.id;
    }
    tolerances.datums = {{"A", datum, Vec3(0, -1, 0)}};
    tolerances.by_face[wall].angularity_mrad = DatumTolerance{angularity_mrad, "A"};
    auto part = measure_part(*bench.session.link, bench.model, tolerances, quick(rounds));
    EXPECT_TRUE(part) << part.error().message;
    return std::move(*part);
  };
  const PartMeasurement coarse = measure(1e3, 0);
  const Criterion before = face_of(coarse, wall).decided_by.value();
  ASSERT_EQ(before.name, "angularity");
  // A limit that this U cannot decide, whatever the angle is.
  const PartMeasurement fine = measure(0.9 * before.U, 1);
  ASSERT_EQ(fine.story.rounds.size(), 1u);
  EXPECT_EQ(fine.story.rounds[0].before.undecided, 1u);
  EXPECT_GT(fine.story.rounds[0].views, 0u);
  // Twice the points of both faces, and more, over the same ground: half the variance, or less.
  for (const int id : {wall, datum})
    EXPECT_GE(face_of(fine, id).points_used, 2 * face_of(coarse, id).points_used) << id;
  EXPECT_LE(face_of(fine, wall).decided_by.value().U, before.U / std::sqrt(2.0));
}

// The cable is pulled when the first scan is whole.
TEST(MeasurePart, ARoundThatBreaksOffLosesNothingElse) {
  const Bench bench = bench_of(kPart);
  auto options = quick(3);
  size_t kept = 0;
  options.keep_scan = [&](const Scan& scan, const ScanCounts&) -> Status {
    kept = scan.size();
    ::kill(bench.session.machine->process(), SIGKILL);
    return Done{};
  };
  const auto part = measure_part(*bench.session.link, bench.model, profile(0.3), options);
  ASSERT_TRUE(part) << part.error().message;
  ASSERT_TRUE(part->interruption);
  EXPECT_EQ(part->interruption->kind, ErrorKind::machine);
  EXPECT_GT(kept, 1000u);
  EXPECT_EQ(part->scan.size(), kept);
  EXPECT_FALSE(part->story.interruption.empty());
  EXPECT_EQ(part->story.interruption.find(bench.session.link->device()), std::string::npos);
  // Judged all the same, and the report says how it was.
  EXPECT_FALSE(part->run.inspection.faces.empty());
  const Tolerances tolerances = profile(0.3);
  const Report report{part->run,     std::span(&part->scan, 1), bench.model, tolerances, {{"scan.ply", ""}},
                      {"model", ""}, {"tolerances", ""},        &part->story};
  EXPECT_NE(report_text(report).find("BROKEN OFF"), std::string::npos);
}

TEST(MeasurePart, StoppedInARoundItIsJudgedToo) {
  const Bench bench = bench_of(kPart);
  auto options = quick(3);
  std::atomic<bool> stop{false};
  options.keep_scan = [&](const Scan&, const ScanCounts&) -> Status {
    stop = true;
    return Done{};
  };
  const auto part = measure_part(*bench.session.link, bench.model, profile(0.3), options, {.stop = &stop});
  ASSERT_TRUE(part) << part.error().message;
  ASSERT_TRUE(part->interruption);
  EXPECT_NE(part->interruption->message.find("laser is off"), std::string::npos)
      << part->interruption->message;
}

TEST(PlanBySurvey, KnowsASymmetryFromAnOpenPose) {
  const Bench bench = bench_of(kCube);
  const RayCaster caster(bench.model);
  const auto turned = [&](double deg, const Vec3& about_mm) -> RigidTransform {
    const Mat3 R = rotation_from_degrees(0, 0, deg);
    return {R, about_mm - R * about_mm};
  };
  const Vec3 middle(20, 20, 20);
  EXPECT_TRUE(stands_alike(bench.model, caster, {}, turned(90, middle)));
  EXPECT_FALSE(stands_alike(bench.model, caster, {}, turned(45, middle)));
  EXPECT_FALSE(stands_alike(bench.model, caster, {}, turned(90, Vec3::Zero())));
  // So a cube, which fits in 24 ways, is planned for all the same.
  const auto machine = read_machine(*bench.session.link);
  ASSERT_TRUE(machine) << machine.error().message;
  const auto plan = plan_by_survey(*bench.session.link, *machine, bench.model, caster, {}, {}, {});
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_NE(plan->how.find("the pose found"), std::string::npos) << plan->how;
}

// Another part than the model's: nothing to match.
TEST(PlanBySurvey, WithoutAPoseLooksFromAllRoundAndSaysSo) {
  const Bench bench = bench_of(kCube);
  const auto other = read_solid(
      temporary_file("other.csg", "cylinder($fn = 4, h = 60, r1 = 40, r2 = 0, center = false);\n"));
  ASSERT_TRUE(other) << other.error().message;
  const auto machine = read_machine(*bench.session.link);
  ASSERT_TRUE(machine) << machine.error().message;
  const auto plan = plan_by_survey(*bench.session.link, *machine, *other, RayCaster(*other), {}, {}, {});
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_NE(plan->how.find("all round"), std::string::npos) << plan->how;
  EXPECT_EQ(plan->scan.views.size(), 8u);
}

TEST(AppendScan, NumbersViewsOn) {
  Scan scan, more;
  scan.points = {Vec3(1, 2, 3)};
  scan.ray_origins = {Vec3(9, 9, 9)};
  scan.sigma_mm = scan.intensity = {0.1f};
  scan.view = {4};
  scan.flags = {0};
  more = scan;
  more.view = {0};
  more.points[0] = Vec3(7, 8, 9);
  more.rejected.push_back({Vec3::Zero(), Vec3::UnitX(), 1, 2});
  append_scan(scan, more, 5);
  ASSERT_EQ(scan.size(), 2u);
  EXPECT_EQ(scan.view, (std::vector<uint32_t>{4, 5}));
  EXPECT_EQ(scan.points[1], Vec3(7, 8, 9));
  ASSERT_EQ(scan.rejected.size(), 1u);
  EXPECT_EQ(scan.rejected[0].view, 7u);
}

}  // namespace
}  // namespace tetragauge
