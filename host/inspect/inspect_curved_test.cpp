// SPDX-License-Identifier: GPL-3.0-or-later
// Parts with hardly a plane, from simulated rays to deviations: a turned part, and one with a ball too large.
// The oracle knows the part's true shape and pose and nothing of the pipeline.
#include "host/inspect/test_scans.hpp"

namespace tetragauge {
namespace {

using namespace test;

std::string at(double x, double y, double z, const std::string& what) {
  return "multmatrix([[1, 0, 0, " + std::to_string(x) + "], [0, 1, 0, " + std::to_string(y) +
         "], [0, 0, 1, " + std::to_string(z) + "], [0, 0, 0, 1]]) { " + what + " }\n";
}

std::string ball(double r) {
  return "sphere($fn = 0, $fa = 12, $fs = 2, r = " + std::to_string(r) + ");";
}

// Cylinder of radius 20 and 30 high, a cone to radius 9 at 55 on it, and a ball.
Solid turned(const Vec3& centre, double radius) {
  return solid("union() {\n" +
               at(0, 0, 0, "cylinder($fn = 0, $fa = 12, $fs = 2, h = 30, r1 = 20, r2 = 20);") +
               at(0, 0, 30, "cylinder($fn = 0, $fa = 12, $fs = 2, h = 25, r1 = 20, r2 = 9);") +
               at(centre.x(), centre.y(), centre.z(), ball(radius)) + "}\n");
}

int the_only(const Solid& model, SurfaceType type) {
  int id = 0;
  for (const Face& face : model.faces()) {
    if (face.type != type) continue;
    EXPECT_EQ(id, 0) << "more than one";
    id = face.id;
  }
  EXPECT_GT(id, 0);
  return std::max(1, id);
}

struct Statistics {
  double mean_mm = 0, rms_mm = 0, p95_mm = 0, max_mm = 0;
  size_t points = 0;
};

Statistics statistics(const std::vector<double>& deviations) {
  Statistics out;
  std::vector<double> sizes;
  for (const double d : deviations) {
    out.mean_mm += d / static_cast<double>(deviations.size());
    out.rms_mm += d * d / static_cast<double>(deviations.size());
    sizes.push_back(std::abs(d));
  }
  out.rms_mm = std::sqrt(out.rms_mm);
  std::sort(sizes.begin(), sizes.end());
  out.points = sizes.size();
  if (sizes.empty()) return out;
  out.p95_mm = sizes[sizes.size() * 95 / 100];
  out.max_mm = sizes.back();
  return out;
}

TEST(InspectCurved, ATurnedPartIsJudgedThoughItsTurnIsFree) {
  const Solid model = turned({0, 0, 55}, 12);
  const InspectionRun run = run_inspect(scan_of(model), model, profile(0.2));
  const Match& match = run.set_ups[0].match;
  EXPECT_EQ(match.found_by, MatchedBy::surface);
  ASSERT_EQ(match.undetermined.size(), 1u);
  EXPECT_EQ(match.undetermined[0].kind, FreeDirection::Kind::rotation);
  for (const FaceInspection& face : run.inspection.faces) {
    EXPECT_TRUE(face.measured) << face.model_id << ": " << face.reason;
    EXPECT_NEAR(face.offset_mm, 0, three_sigma(face.U_offset_mm));
  }
  EXPECT_EQ(run.inspection.verdict, Verdict::pass);
}

TEST(InspectCurved, ABallTooLargeIsNamedWithItsDeviations) {
  const Vec3 centre(17, 0, 17);
  const Solid model = turned(centre, 12), part = turned(centre, 12.1);
  View view;
  view.points = 12000;
  const Scan scan = scan_of(part, view);
  const InspectionRun run = run_inspect(scan, model, profile(0.15));

  // True shape, true pose: which face a point is of, and how far off the model's.
  std::vector<double> of_ball, of_body;
  for (const Vec3& measured : scan.points) {
    const Vec3 p = view.T_scan_model.inverse() * measured;
    const double from_ball = (p - centre).norm() - 12.1, radius = std::hypot(p.x(), p.y());
    const bool on_ball = std::abs(from_ball) < 0.15, on_body = std::abs(radius - 20) < 0.15;
    if (on_ball && !on_body && radius > 20.6) of_ball.push_back(from_ball + 0.1);
    if (on_body && !on_ball && p.z() > 1 && p.z() < 29 && from_ball > 0.6) of_body.push_back(radius - 20);
  }
  for (const auto& [id, deviations] : {std::pair(the_only(model, SurfaceType::sphere), of_ball),
                                       std::pair(the_only(model, SurfaceType::cylinder), of_body)}) {
    const Statistics truth = statistics(deviations);
    const FaceInspection& face = result(run, id);
    EXPECT_NEAR(static_cast<double>(face.points_used), static_cast<double>(truth.points),
                0.1 * static_cast<double>(truth.points));
    EXPECT_NEAR(face.point_mean_mm, truth.mean_mm, three_sigma(face.U_offset_mm)) << id;
    EXPECT_NEAR(face.point_rms_mm, truth.rms_mm, 0.003) << id;
    EXPECT_NEAR(face.point_p95_mm, truth.p95_mm, 0.005) << id;
    EXPECT_NEAR(face.point_max_mm, truth.max_mm, 0.03) << id;
  }
  const FaceInspection& sphere = result(run, the_only(model, SurfaceType::sphere));
  ASSERT_TRUE(sphere.radius_mm && sphere.position_mm);
  EXPECT_NEAR(*sphere.radius_mm, 0.1, three_sigma(sphere.U_radius_mm));
  EXPECT_NEAR(*sphere.position_mm, 0, three_sigma(sphere.U_position_mm));
  EXPECT_LT(sphere.U_position_mm, 0.05);
  for (const FaceInspection& face : run.inspection.faces)
    EXPECT_EQ(face.verdict, face.model_id == sphere.model_id ? Verdict::fail : Verdict::pass)
        << face.model_id << " " << face.profile_mm << " " << face.U_profile_mm;
}

// The ball has more than a quarter of all points: out of size it is the ball that fails and not the pose, and
// the flat pieces that a coarse scan makes of it are no faces beside the model's.
TEST(InspectCurved, ABallOutOfSizeOnAShaftIsNamed) {
  const auto shaft = [](double r) {
    const auto post = [](double height, double radius) {
      const std::string r12 = std::to_string(radius);
      return "cylinder($fn = 0, $fa = 12, $fs = 2, h = " + std::to_string(height) + ", r1 = " + r12 +
             ", r2 = " + r12 + ");";
    };
    return solid("union() {\n" + at(0, 0, 0, post(6, 15)) + at(0, 0, 0, post(30, 6)) +
                 at(0, 0, 14, post(4, 11)) + at(0, 0, 34, ball(r)) + "}\n");
  };
  const Solid model = shaft(9);
  for (const auto& [growth, points] :
       {std::pair(0.3, 20000), std::pair(-0.3, 7500), std::pair(0.8, 7500), std::pair(-0.8, 20000)}) {
    View view;
    view.points = static_cast<size_t>(points);
    view.sigma_mm = 0.03;
    view.T_scan_model = {rotation_from_degrees(75, -35, 110), Vec3(-20, 40, 10)};
    const InspectionRun run = run_inspect(scan_of(shaft(9 + growth), view), model, profile(0.2));
    const Match& match = run.set_ups[0].match;
    EXPECT_EQ(match.found_by, MatchedBy::surface);
    EXPECT_EQ(match.undetermined.size(), 1u);
    EXPECT_TRUE(match.equivalents.empty());
    const FaceInspection& sphere = result(run, the_only(model, SurfaceType::sphere));
    EXPECT_EQ(sphere.verdict, Verdict::fail) << growth;
    ASSERT_TRUE(sphere.radius_mm);
    EXPECT_NEAR(*sphere.radius_mm, growth, three_sigma(sphere.U_radius_mm));
    EXPECT_NEAR(sphere.offset_mm, growth, three_sigma(sphere.U_offset_mm));
    for (const FaceInspection& face : run.inspection.faces) {
      if (face.model_id != sphere.model_id) {
        EXPECT_EQ(face.verdict, Verdict::pass) << growth << " " << face.model_id;
      }
    }
    EXPECT_TRUE(run.inspection.extra_faces.empty()) << growth;
  }
}

// Where a plane goes over into a fillet without an edge, the first strip of the fillet passes for the plane
// within the noise: no material in excess beyond the plane's end.
TEST(InspectCurved, AGoodPartWithRoundedEdgesPasses) {
  const auto post = [](double x, double y, double r) {
    const std::string radius = std::to_string(r);
    return at(x, y, 0,
              "cylinder($fn = 0, $fa = 12, $fs = 2, h = 15, r1 = " + radius + ", r2 = " + radius + ");");
  };
  const auto block = [](double y, double length, double width) {
    return at(
        0, y, 0,
        "cube(size = [" + std::to_string(length) + ", " + std::to_string(width) + ", 15], center = false);");
  };
  // 19 x 5 x 15 mm; one end round, the edges of the other rounded by 1 mm.
  const Solid model = solid("union() {\n" + block(-2.5, 15, 5) + post(0, 0, 2.5) + block(-1.5, 16, 3) +
                            post(15, -1.5, 1) + post(15, 1.5, 1) + "}\n");
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    View view;
    view.points = 20000;
    view.sigma_mm = 0.03;
    view.seed = seed;
    view.T_scan_model = {rotation_from_degrees(20, 30, 40), Vec3(5, 6, 7)};
    const InspectionRun run = run_inspect(scan_of(model, view), model, profile(0.4));
    EXPECT_EQ(run.inspection.verdict, Verdict::pass) << seed;
    EXPECT_TRUE(run.inspection.material_faults.empty()) << seed;
    // Nor does the fillet draw the part aside: thousands of points hold it to a micrometre.
    const RigidTransform error = run.set_ups[0].match.T_model_part * view.T_scan_model;
    EXPECT_LT((error * model.centroid_mm - model.centroid_mm).norm(), 0.0015) << seed;
  }
}

}  // namespace
}  // namespace tetragauge
