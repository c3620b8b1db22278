// SPDX-License-Identifier: GPL-3.0-or-later
// Faces that light treats unkindly: narrower than the points' errors are wide, or turning away under a
// grazing spot.
#include "host/inspect/test_scans.hpp"

namespace tetragauge {
namespace {

using namespace test;

TEST(MeasureFace, RisersHardlyWiderThanThePointsErrorsAreNotTurned) {
  // Six steps of 0.8 mm, seen from a cube's corners: sigma 0.06 along the rays moves points by as much over a
  // riser as they are spread on it. Oracle: the part is the model.
  Outline steps{{0, 0}, {60, 0}};
  for (int k = 6; k > 0; --k) {
    steps.push_back({10.0 * k, 7.8 - 0.8 * k});
    steps.push_back({10.0 * (k - 1), 7.8 - 0.8 * k});
  }
  const Solid model = solid(swept(steps, 0, 40));
  Vec3 lean = Vec3::Zero();
  double variance = 0;
  int risers = 0;
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    const View view{45000, 0.06, seed};
    const InspectionRun run = run_inspect(scan_of(model, view), model, profile(0.2));
    for (const FaceInspection& face : run.inspection.faces) {
      const Face& of_model = model.faces()[static_cast<size_t>(face.model_id) - 1];
      EXPECT_NE(face.verdict, Verdict::fail)
          << face.model_id << ": " << face.profile_mm << " " << face.U_profile_mm;
      if (of_model.area_mm2 > 40 || !face.plane) continue;
      EXPECT_LT(face.tilt_rad, three_sigma(face.U_tilt_rad)) << face.model_id;
      lean += face.plane->normal - of_model.normal;
      variance += face.U_tilt_rad * face.U_tilt_rad / 4;
      ++risers;
    }
  }
  EXPECT_GE(risers, 8);
  // All of them together do not lean up or down either.
  EXPECT_LT(std::abs(lean.z()), 3 * std::sqrt(variance));
}

// A peg of radius 5 about (22, 12) on a plate, up to z 19.
Solid peg() {
  return solid(
      "union() { cube(size = [44, 32, 6], center = false);\n"
      "multmatrix([[1, 0, 0, 22], [0, 1, 0, 12], [0, 0, 1, 5], [0, 0, 0, 1]]) {\n"
      "  cylinder($fn = 0, h = 14, r1 = 5, r2 = 5, center = false); } }");
}

double distance_to_peg(const Vec3& p) {
  const double aside = std::hypot(p.x() - 22, p.y() - 12) - 5, above = p.z() - 19;
  return std::hypot(std::max(0.0, aside), std::max(0.0, above));
}

TEST(MeasureFace, ABeamThatClipsAnEdgeOnItsWayIsLeftOut) {
  // Oracle: the distance of each beam's axis to the true peg, by small steps. Six rays about a beam of radius
  // 0.2 miss nothing that comes within 0.2 cos 30 of its axis.
  const Solid model = peg();
  const View view{30000, 0.03};
  Scan scan = scan_of(model, view);
  const RigidTransform T_model_scan = view.T_scan_model.inverse();
  size_t must_go = 0, may_go = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vec3 p = T_model_scan * scan.points[i], ray = T_model_scan.R * scan.ray_direction(i);
    if (std::abs(p.z() - 6) > 0.15) continue;
    const double from_edge = std::min({p.x(), 44 - p.x(), p.y(), 32 - p.y()});
    if (from_edge < 1 || distance_to_peg(p) < 1) {  // its own edges' share
      ++may_go;
      continue;
    }
    double nearest_mm = 1e300;
    for (double back = 0.5; back < 40; back += 0.02)
      nearest_mm = std::min(nearest_mm, distance_to_peg(p - back * ray));
    must_go += nearest_mm < 0.17;
    may_go += nearest_mm < 0.21;
  }
  ASSERT_GT(must_go, 20u);
  const int plate = face_at(model, Vec3::UnitZ(), 6);
  const size_t without = result(run_inspect(scan, model, profile(0.1)), plate).points_used;
  scan.header.spot_mm = 0.2;
  const size_t with = result(run_inspect(scan, model, profile(0.1)), plate).points_used;
  EXPECT_LE(with + must_go, without);
  EXPECT_GE(with + may_go, without);
}

TEST(MeasureFace, AFaceNarrowerThanTheBeamIsNotMeasured) {
  const Solid model = solid(swept({{0, 0}, {40, 0}, {40, 10}, {20, 10}, {20, 10.35}, {0, 10.35}}, 0, 30));
  Scan scan = scan_of(model, {60000, 0.01});
  const int step = face_at(model, Vec3::UnitX(), 20);
  EXPECT_TRUE(result(run_inspect(scan, model, profile(0.2)), step).measured);
  scan.header.spot_mm = 0.2;
  const InspectionRun run = run_inspect(scan, model, profile(0.2));
  EXPECT_EQ(result(run, step).reason.find("too narrow for the beam"), 0u) << result(run, step).reason;
  for (const FaceInspection& face : run.inspection.faces)
    EXPECT_EQ(face.verdict, face.model_id == step ? Verdict::not_measured : Verdict::pass) << face.model_id;
}

TEST(MeasureFace, GrazingLightDoesNotMoveAPeg) {
  // Where a camera sees a part of the spot only, points at more than 70 degrees come out 8 sigma too near.
  const Solid model = peg();
  const View view{30000, 0.03};
  Scan scan = scan_of(model, view);
  const RigidTransform T_model_scan = view.T_scan_model.inverse();
  size_t moved = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vec3 p = T_model_scan * scan.points[i], ray = T_model_scan.R * scan.ray_direction(i);
    const Vec3 out = Vec3(p.x() - 22, p.y() - 12, 0);
    if (std::abs(out.norm() - 5) > 0.15 || p.z() < 6.3 || p.x() > 22) continue;  // of one side
    if (-ray.dot(out.normalized()) > std::cos(70 * 3.14159265 / 180)) continue;
    scan.points[i] -= 0.24 * scan.ray_direction(i);
    ++moved;
  }
  ASSERT_GT(moved, 30u);
  const InspectionRun run = run_inspect(scan, model, profile(0.2));
  for (const FaceInspection& face : run.inspection.faces) {
    if (!face.radius_mm) continue;
    EXPECT_EQ(face.verdict, Verdict::pass);
    EXPECT_LT(std::abs(*face.radius_mm), three_sigma(face.U_radius_mm));
    EXPECT_LT(*face.position_mm, three_sigma(face.U_position_mm));
  }
}

TEST(MeasureFace, ABoreFarOutOfPlaceIsNoNarrower) {
  // By 0.6 mm at a radius of 5, and 0.02 too wide: where one linear step would have it 0.036 narrower.
  const auto plate = [](double x, double r) {
    return solid(
        "difference() { cube(size = [40, 30, 12], center = false);\n"
        "multmatrix([[1, 0, 0, " +
        std::to_string(x) +
        "], [0, 1, 0, 15], [0, 0, 1, -1], [0, 0, 0, 1]]) {\n"
        "  cylinder($fn = 0, h = 14, r1 = " +
        std::to_string(r) + ", r2 = " + std::to_string(r) + ", center = false); } }");
  };
  const Solid model = plate(20, 5), part = plate(20.6, 5.02);
  const InspectionRun run = run_inspect(scan_of(part, {20000, 0.01}), model, profile(0.2));
  int bores = 0;
  for (const FaceInspection& face : run.inspection.faces) {
    if (!face.radius_mm) continue;
    ++bores;
    EXPECT_NEAR(*face.radius_mm, 0.02, three_sigma(face.U_radius_mm));
    EXPECT_LT(face.U_radius_mm, 0.01);
    EXPECT_NEAR(*face.position_mm, 0.6, three_sigma(face.U_position_mm));
    EXPECT_NEAR(std::abs(face.profile_mm), 0.62, three_sigma(face.U_profile_mm));
  }
  EXPECT_EQ(bores, 1);
}

}  // namespace
}  // namespace tetragauge
