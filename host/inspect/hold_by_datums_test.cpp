// SPDX-License-Identifier: GPL-3.0-or-later
// Parts held by their datums, faces against datums and against one another.
#include <algorithm>
#include <numbers>

#include "host/inspect/test_scans.hpp"

namespace tetragauge {
namespace {

using namespace test;

TEST(Datums, ABoreOutOfPlaceIsMeasured) {
  // 0.1 mm along x; its radius is right. Position is a zone of full width, here a diameter.
  const auto block = [](double x) {
    return "difference() { cube(size = [60, 50, 20], center = false); multmatrix([[1, 0, 0, " +
           std::to_string(x) +
           "], [0, 1, 0, 20], [0, 0, 1, -1], [0, 0, 0, 1]]) { cylinder($fn = 0, $fa = 12, $fs = 2, h = 22, "
           "r1 = 12, r2 = 12, center = false); } }\n";
  };
  const Solid model = solid(block(20)), part = solid(block(20.1));
  const auto bore = std::find_if(model.faces().begin(), model.faces().end(),
                                 [](const Face& face) { return face.type == SurfaceType::cylinder; });
  ASSERT_NE(bore, model.faces().end());
  const int top = face_at(model, Vec3::UnitZ(), 20);
  Tolerances tolerances;
  tolerances.given = true;
  tolerances.datums = {{"A", top, Vec3::UnitZ()},
                       {"B", face_at(model, -Vec3::UnitX(), 0), -Vec3::UnitX()},
                       {"C", face_at(model, -Vec3::UnitY(), 0), -Vec3::UnitY()}};
  FaceTolerance& of_bore = tolerances.by_face[bore->id];
  of_bore.position_mm = DatumTolerance{0.1, "A"};
  of_bore.perpendicularity_mm = DatumTolerance{0.1, "A"};
  of_bore.radius_mm = 0.05;
  const InspectionRun run = run_inspect(scan_of(part), model, tolerances);
  const FaceInspection& out = result(run, bore->id);
  EXPECT_EQ(out.verdict, Verdict::fail);
  ASSERT_TRUE(out.decided_by.has_value());
  EXPECT_EQ(out.decided_by->name, "position");
  EXPECT_NEAR(out.decided_by->deviation, 0.1, three_sigma(out.decided_by->U));
  EXPECT_LT(out.decided_by->U, 0.03);
  for (const Criterion& criterion : out.criteria) {
    if (criterion.name == "position") continue;
    EXPECT_EQ(criterion.verdict, Verdict::pass) << criterion.name;
    EXPECT_LT(std::abs(criterion.deviation), three_sigma(criterion.U)) << criterion.name;
  }
}

TEST(Datums, WithDatumsTheFaceThatMovedIsNamed) {
  const Solid model = staircase(), part = solid(swept(kStaircase, 0, 60.2));
  const int bottom = face_at(model, -Vec3::UnitZ(), 0), end = face_at(model, Vec3::UnitX(), 80);
  const int front = face_at(model, -Vec3::UnitY(), 0), back = face_at(model, Vec3::UnitY(), 60);
  Tolerances tolerances = profile(0.1);
  tolerances.datums = {
      {"A", bottom, -Vec3::UnitZ()}, {"B", end, Vec3::UnitX()}, {"C", front, -Vec3::UnitY()}};
  const InspectionRun run = run_inspect(scan_of(part), model, tolerances);
  EXPECT_EQ(run.inspection.verdict, Verdict::fail);
  for (const FaceInspection& face : run.inspection.faces)
    EXPECT_EQ(face.verdict, face.model_id == back ? Verdict::fail : Verdict::pass) << face.model_id;
  EXPECT_NEAR(result(run, back).offset_mm, 0.2, three_sigma(result(run, back).U_offset_mm));
  EXPECT_LT(result(run, back).U_offset_mm, 0.02);
  // 3-2-1: what each datum holds, and that it then lies where it should.
  const auto& held = run.inspection.alignment.datums;
  ASSERT_EQ(held.size(), 3u);
  EXPECT_EQ(held[0].rotations, 2);
  EXPECT_EQ(held[0].translations, 1);
  EXPECT_EQ(held[1].rotations, 1);
  EXPECT_EQ(held[1].translations, 1);
  EXPECT_EQ(held[2].rotations, 0);
  EXPECT_EQ(held[2].translations, 1);
  // But for the points at its two long edges that the pose gives it or takes from it as it moves by half of
  // 0.2 mm.
  const double points = static_cast<double>(result(run, bottom).points_used);
  const double exchanged = points / (80 * 60) * 2 * 80 * 0.1;
  EXPECT_LT(std::abs(result(run, bottom).offset_mm), 3 * std::sqrt(exchanged) * View{}.sigma_mm / points);
  EXPECT_LT(result(run, bottom).tilt_rad, 1e-5);
  EXPECT_LT(std::abs(result(run, front).offset_mm), 1e-3);  // at its points' centroid it is 0
  // The pose takes the front where the drawing has it: the truth is known from the simulation.
  const RigidTransform error = run.set_ups[0].match.T_model_part * View{}.T_scan_model;
  EXPECT_LT((error * model.centroid_mm - model.centroid_mm).norm(), 0.01);
}

TEST(Datums, UncertaintyFromDatumsHoldsTheTruth) {
  // As UncertaintyHoldsTheTruth, with the part held by three datums: their noise moves all other faces.
  const Solid model = staircase();
  Tolerances tolerances;
  const int a = face_at(model, Vec3::UnitX(), 20), b = face_at(model, -Vec3::UnitY(), 0),
            c = face_at(model, Vec3::UnitZ(), 60);
  tolerances.datums = {{"A", a, Vec3::UnitX()}, {"B", b, -Vec3::UnitY()}, {"C", c, Vec3::UnitZ()}};
  int beyond = 0, faces = 0;
  double mean_square = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    View view;
    view.points = 4000;
    view.seed = seed;
    const InspectionRun run = run_inspect(scan_of(model, view), model, tolerances);
    for (const FaceInspection& face : run.inspection.faces) {
      if (face.model_id == a || face.model_id == b || face.model_id == c) continue;
      ++faces;
      beyond += std::abs(face.offset_mm) > face.U_offset_mm;
      mean_square += std::pow(2 * face.offset_mm / face.U_offset_mm, 2);
    }
  }
  EXPECT_EQ(faces, 12 * 12);
  // Faces of one scan share the datums' errors: some 3 of 12 are independent, and so the scatter is doubled.
  EXPECT_LE(beyond, 20);
  EXPECT_GT(mean_square / faces, 0.4);
  EXPECT_LT(mean_square / faces, 1.8);
}

TEST(Datums, ADatumThatWasNotSeenDecidesNothing) {
  const Solid model = staircase();
  const int bottom = face_at(model, -Vec3::UnitZ(), 0), top = face_at(model, Vec3::UnitZ(), 60);
  Tolerances tolerances = profile(0.2);
  tolerances.by_face[top].flatness_mm = 0.1;
  tolerances.by_face[top].parallelism_mm = DatumTolerance{0.1, "A"};
  tolerances.datums = {{"A", bottom, -Vec3::UnitZ()}};
  tolerances.skip = {bottom};
  const Scan whole = scan_of(model);
  const RigidTransform T_model_scan = View{}.T_scan_model.inverse();
  const Scan scan = points_of(whole, [&](size_t i) { return (T_model_scan * whole.points[i]).z() > 0.5; });
  const InspectionRun run = run_inspect(scan, model, tolerances);
  EXPECT_EQ(run.inspection.verdict, Verdict::undecided);
  EXPECT_TRUE(run.inspection.alignment.datums.empty());
  EXPECT_NE(run.inspection.alignment.problem.find("datum A (face " + std::to_string(bottom) + ")"),
            std::string::npos);
  for (const FaceInspection& face : run.inspection.faces) {
    if (face.model_id == bottom) continue;
    EXPECT_EQ(face.verdict, Verdict::undecided) << face.model_id;
    EXPECT_NE(face.reason.find("datum A"), std::string::npos) << face.reason;
  }
  // What needs no datum is judged all the same.
  const auto& criteria = result(run, top).criteria;
  EXPECT_TRUE(std::any_of(criteria.begin(), criteria.end(), [](const Criterion& c) {
    return c.name == "flatness" && c.verdict == Verdict::pass;
  }));
}

TEST(Datums, OrientationIsJudgedAgainstItsDatumAlone) {
  // The riser x = 60 leans out by 0.2 mm over its 20 mm; the part is not held by the datum's neighbours.
  Outline outline = kStaircase;
  outline[4][0] = 60.2;
  const Solid model = staircase(), part = solid(swept(outline, 0, 60));
  const int riser = face_at(model, Vec3::UnitX(), 60), tread = face_at(model, Vec3::UnitZ(), 20),
            end = face_at(model, Vec3::UnitX(), 80);
  Tolerances tolerances;
  tolerances.given = true;
  tolerances.datums = {{"A", tread, Vec3::UnitZ()}, {"B", end, Vec3::UnitX()}};
  tolerances.by_face[riser].perpendicularity_mm = DatumTolerance{0.1, "A"};
  tolerances.by_face[riser].parallelism_mm = DatumTolerance{0.1, "B"};
  tolerances.by_face[riser].angularity_mrad = DatumTolerance{5, "A"};
  tolerances.by_face[riser].position_mm = DatumTolerance{0.3, "B"};  // +- 0.15
  const InspectionRun run = run_inspect(scan_of(part), model, tolerances);
  const auto& criteria = result(run, riser).criteria;
  ASSERT_EQ(criteria.size(), 4u);
  const double expected[] = {0.2, 0.2, 0.2, 10};  // position, parallelism, perpendicularity, angularity
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(std::abs(criteria[k].deviation), expected[k], three_sigma(criteria[k].U)) << criteria[k].name;
    EXPECT_LT(criteria[k].U, 0.2 * expected[k]) << criteria[k].name;
    EXPECT_EQ(criteria[k].verdict, Verdict::fail) << criteria[k].name;
  }
  EXPECT_EQ(criteria[0].name, "position");
  EXPECT_EQ(criteria[3].name, "angularity");
  EXPECT_EQ(criteria[3].datum, "A");
}

TEST(Datums, DistancesAndAnglesNeedNoPose) {
  Outline outline = kStaircase;
  outline[3][0] = 60.3;  // the riser x = 60: 0.3 mm out below, 0.5 mm above
  outline[4][0] = 60.5;
  const Solid model = staircase(), part = solid(swept(outline, 0, 60));
  const InspectionRun run = run_inspect(scan_of(part), model, {});
  const int riser = face_at(model, Vec3::UnitX(), 60), end = face_at(model, Vec3::UnitX(), 80),
            tread = face_at(model, Vec3::UnitZ(), 20);
  const auto relation = [&](int a, int b) {
    for (const FaceRelation& r : run.inspection.relations)
      if (r.first == std::min(a, b) && r.second == std::max(a, b)) return r;
    ADD_FAILURE() << a << " " << b;
    return FaceRelation{};
  };
  const FaceRelation across = relation(riser, end);
  EXPECT_TRUE(across.are_parallel);
  EXPECT_FALSE(across.are_neighbours);
  EXPECT_DOUBLE_EQ(across.nominal_distance_mm, 20);
  // Taken at the height amid their centroids (30 and 10): there, at z = 20, the riser stands at 60.3.
  EXPECT_NEAR(across.distance_deviation_mm, -0.3, three_sigma(across.U_distance_mm));
  EXPECT_LT(across.U_distance_mm, 0.03);
  EXPECT_NEAR(across.angle_deviation_rad, 0.01, three_sigma(across.U_angle_rad));
  const FaceRelation corner = relation(riser, tread);
  EXPECT_TRUE(corner.are_neighbours);
  EXPECT_NEAR(corner.nominal_angle_rad, std::numbers::pi / 2, 1e-9);
  // The riser's normal turns down by 10 mrad, away from the tread's.
  EXPECT_NEAR(corner.angle_deviation_rad, 0.01, three_sigma(corner.U_angle_rad));
  // What did not move lies as it should: 5 % may be beyond U.
  int good = 0, beyond = 0;
  for (const FaceRelation& r : run.inspection.relations) {
    if (r.first == riser || r.second == riser || !r.are_parallel) continue;
    ++good;
    beyond += std::abs(r.distance_deviation_mm) > r.U_distance_mm;
  }
  EXPECT_GT(good, 15);
  EXPECT_LE(beyond, 4);
}

}  // namespace
}  // namespace tetragauge
