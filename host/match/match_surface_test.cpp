// SPDX-License-Identifier: GPL-3.0-or-later
// Parts with hardly a plane, scanned by simulation from poses of our choice: the pose must come back.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "host/match/faces_out.hpp"
#include "host/match/match.hpp"
#include "host/match/rank_poses.hpp"
#include "host/match/settle_on_surface.hpp"
#include "host/simulate/simulate.hpp"

namespace tetragauge {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Solid solid(const std::string& csg) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
                                     (std::string("tetragauge_surface_") + info->name() + ".csg");
  std::ofstream(path, std::ios::binary) << csg;
  Result<Solid> read = read_solid(path);
  std::filesystem::remove(path);
  if (!read) {
    ADD_FAILURE() << read.error().message;
    return {};
  }
  return std::move(read).value();
}

std::string ball(double x, double y, double z, double r) {
  return "multmatrix([[1, 0, 0, " + std::to_string(x) + "], [0, 1, 0, " + std::to_string(y) +
         "], [0, 0, 1, " + std::to_string(z) +
         "], [0, 0, 0, 1]]) { sphere($fn = 0, $fa = 12, $fs = 2, r = " + std::to_string(r) + "); }\n";
}

std::string post(double x, double y, double height, double foot, double top) {
  return "multmatrix([[1, 0, 0, " + std::to_string(x) + "], [0, 1, 0, " + std::to_string(y) +
         "], [0, 0, 1, 0], [0, 0, 0, 1]]) { cylinder($fn = 0, $fa = 12, $fs = 2, h = " +
         std::to_string(height) + ", r1 = " + std::to_string(foot) + ", r2 = " + std::to_string(top) +
         ", center = false); }\n";
}

struct Simulated {
  Result<Match> match;
  RigidTransform T_scan_model;
};

Simulated match_seen_from(const Solid& part, const Solid& model, const std::vector<Vec3>& directions,
                          const RigidTransform& T, uint64_t seed) {
  const RayCaster caster(model);
  SimulateOptions options;
  options.points = 6000;
  options.sigma_mm = 0.05;
  options.seed = seed;
  options.T_scan_model = T;
  for (const Vec3& direction : directions)
    options.view_points_mm.push_back(T * (model.centroid_mm + 300 * direction));
  const Result<Scan> scan = simulate(part, RayCaster(part), options);
  EXPECT_TRUE(scan.ok());
  const Result<Reconstruction> reconstruction = reconstruct(*scan);
  EXPECT_TRUE(reconstruction.ok());
  const Result<MeasuredFaces> faces = find_faces(*scan, *reconstruction);
  EXPECT_TRUE(faces.ok());
  return {match_scan(model, caster, *scan, *faces), T};
}

Simulated match_seen_from(const Solid& model, const std::vector<Vec3>& directions, const RigidTransform& T,
                          uint64_t seed) {
  return match_seen_from(model, model, directions, T, seed);
}

// Within five standard deviations of its own covariance, along every direction; and that covariance must not
// be an excuse.
void expect_true_pose(const Simulated& run, const Vec3& centroid) {
  ASSERT_TRUE(run.match.ok()) << run.match.error().message;
  const RigidTransform error = run.match->T_model_part * run.T_scan_model;
  const Vec3 shift = error * centroid - centroid;
  const Eigen::AngleAxisd turn(error.R);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(turn.angle() * turn.axis()[k]), 5 * std::sqrt(run.match->covariance(k, k)));
    EXPECT_LT(std::abs(shift[k]), 5 * std::sqrt(run.match->covariance(k + 3, k + 3)));
    EXPECT_LT(std::sqrt(run.match->covariance(k, k)), 0.3 * kDegree);
    EXPECT_LT(std::sqrt(run.match->covariance(k + 3, k + 3)), 0.1);
  }
}

const RigidTransform kPoses[] = {{rotation_from_degrees(75, -35, 110), Vec3(-20, 40, 10)},
                                 {rotation_from_degrees(-160, 20, 15), Vec3(5, -60, 33)}};

// A scan of the part as the fit to the model's surface sees it, with the true pose known.
struct SurfaceProblemRun {
  RigidTransform T_scan_model = kPoses[0];
  Scan scan;
  SurfaceProblem problem;
  SurfaceScatter scatter;

  SurfaceProblemRun(const Solid& part, const Solid& model, const RayCaster& caster, const RayCaster& of_part,
                    uint64_t seed)
      : scan(scan_of(part, of_part, seed, 0.03)),
        problem(surface_problem(model, caster, scan)),
        scatter(surface_scatter(problem, ray_residuals(problem, T_scan_model.inverse(), 30000))) {}

  static Scan scan_of(const Solid& part, const RayCaster& caster, uint64_t seed, double sigma_mm) {
    SimulateOptions options;
    options.points = 3000;
    options.sigma_mm = sigma_mm;
    options.seed = seed;
    options.T_scan_model = kPoses[0];
    Result<Scan> scan = simulate(part, caster, options);
    EXPECT_TRUE(scan.ok());
    return std::move(scan).value();
  }
};

TEST(MatchSurface, ACappedCylinderWithABossSeenFromOneSide) {
  const Solid model =
      solid("union() {\n" + post(0, 0, 50, 20, 20) + ball(0, 0, 50, 20) + ball(14, 6, 62, 9) + "}\n");
  for (size_t k = 0; k < 2; ++k) {
    const Simulated run = match_seen_from(model, {Vec3(1, 0.4, 0.8).normalized()}, kPoses[k], k + 1);
    expect_true_pose(run, model.centroid_mm);
    EXPECT_EQ(run.match->found_by, MatchedBy::surface);
    EXPECT_TRUE(run.match->undetermined.empty());
    EXPECT_TRUE(run.match->equivalents.empty());
  }
}

std::string turned_block(const std::string& block, double x, double y, double z) {
  return "multmatrix([[1, 0, 0, " + std::to_string(x) + "], [0, 1, 0, " + std::to_string(y) +
         "], [0, 0, 1, " + std::to_string(z) + "], [0, 0, 0, 1]]) { " + block + " }\n";
}

TEST(MatchSurface, AConeWithAFlatIsHeldByBoth) {
  // The flat alone says how the cone is turned, and only the cone where it is along the flat.
  const Solid model = solid("difference() {\n" + post(0, 0, 45, 22, 10) +
                            turned_block("cube(size = [20, 60, 60], center = false);", 13, -30, -5) + "}\n");
  const Simulated run =
      match_seen_from(model, {Vec3(1, 0.5, 0.6).normalized(), Vec3(-0.4, 1, 0.3).normalized()}, kPoses[1], 3);
  expect_true_pose(run, model.centroid_mm);
  EXPECT_TRUE(run.match->undetermined.empty());
  EXPECT_TRUE(run.match->equivalents.empty());
  EXPECT_EQ(run.match->found_by, MatchedBy::surface);
  EXPECT_EQ(run.match->surface_fit.why, "its planes leave directions free");
  // Simulated noise is 0.05 mm along rays that meet the surface at up to 80 degrees.
  EXPECT_LT(run.match->surface_fit.scatter_mm, 0.05);
  EXPECT_GT(run.match->surface_fit.scatter_mm, 0.02);
  EXPECT_GT(run.match->surface_fit.explained, 0.97);
}

TEST(MatchSurface, ABallTooLargeHoldsThePartByItsCentre) {
  // A turned part whose turn only a ball at its side holds; of the real part that ball is 0.1 mm too large.
  const auto knob = [](double r) {
    return solid(
        "union() {\n" + post(0, 0, 30, 20, 20) +
        turned_block("cylinder($fn = 0, $fa = 12, $fs = 2, h = 25, r1 = 20, r2 = 9, center = false);", 0, 0,
                     30) +
        ball(17, 0, 17, r) + "}\n");
  };
  const Solid model = knob(12), part = knob(12.1);
  const RayCaster caster(model), of_part(part);
  const SurfaceProblemRun run(part, model, caster, of_part, 2);
  // Turned by 8 mrad, one side of the ball lies where the model's does: there a fit that takes points one by
  // one stays.
  Vec6 turn = Vec6::Zero();
  turn[2] = 0.008;
  const PolishedPose found = polish_with_faces_out(
      run.problem, nudged(run.T_scan_model.inverse(), turn, model.centroid_mm), run.scatter, 30000, 18, 1.0);
  const RigidTransform error = found.T_model_part * run.T_scan_model;
  EXPECT_LT(rotation_angle(error.R), 0.001);
  EXPECT_LT((error * model.centroid_mm - model.centroid_mm).norm(), 0.01);
}

// The oracle is the scatter of 40 poses about the truth, each in units of the covariance that it states: the
// sum of the squares has a chi-square distribution with as many degrees of freedom as there are directions
// held.
void expect_scatter_as_stated(const Solid& part, const Solid& model, double sigma_mm, int held) {
  const RayCaster caster(model), of_part(part);
  constexpr double kMostOut_mm = 1;
  const RigidTransform& T_scan_model = kPoses[0];
  double chi2 = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const Scan scan = SurfaceProblemRun::scan_of(part, of_part, seed, sigma_mm);
    const SurfaceProblem problem = surface_problem(model, caster, scan);
    Vec6 off;
    off << 3e-4, -2e-4, 2e-4, sigma_mm, -sigma_mm, sigma_mm;
    const RigidTransform start = nudged(T_scan_model.inverse(), off, model.centroid_mm);
    const SurfaceScatter rough = surface_scatter(problem, ray_residuals(problem, start, scan.size()));
    const SettledPose settled = settle_on_surface(problem, start, rough, kMostOut_mm);
    EXPECT_EQ(settled.freedom.undetermined.size(), static_cast<size_t>(6 - held));
    const RigidTransform error = settled.pose.T_model_part * T_scan_model;
    const Eigen::AngleAxisd turn(error.R);
    const double arm_mm = 0.3 * problem.size_mm;
    Vec6 e, unit;
    e << turn.angle() * turn.axis(), error * model.centroid_mm - model.centroid_mm;
    unit << Vec3::Constant(arm_mm), Vec3::Ones();
    const Mat6 covariance = unit.asDiagonal() * settled.freedom.covariance * unit.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(covariance);  // ascending; free directions have none
    for (int k = 6 - held; k < 6; ++k)
      chi2 += std::pow(eigen.eigenvectors().col(k).dot(unit.cwiseProduct(e)), 2) / eigen.eigenvalues()[k];
  }
  // One in a thousand lies above, one below (Wilson and Hilferty, PNAS 17 (1931) 684).
  const double freedom = 40 * held, spread = 2 / (9 * freedom);
  EXPECT_LT(chi2, freedom * std::pow(1 - spread + 3.09 * std::sqrt(spread), 3));
  EXPECT_GT(chi2, freedom * std::pow(1 - spread - 3.09 * std::sqrt(spread), 3));
}

std::string capped_cylinder(double boss) {
  return "union() {\n" + post(0, 0, 50, 20, 20) + ball(0, 0, 50, 20) + ball(14, 6, 62, boss) + "}\n";
}

std::string ball_on_a_shaft(double r) {
  return "union() {\n" + post(0, 0, 6, 15, 15) + post(0, 0, 18, 11, 11) + post(0, 0, 30, 6, 6) +
         ball(0, 0, 34, r) + "}\n";
}

TEST(MatchSurface, PosesScatterAsTheirCovariancesSay) {
  const Solid model = solid(capped_cylinder(9));
  expect_scatter_as_stated(model, model, 0.03, 6);
  expect_scatter_as_stated(model, model, 0.1, 6);
}

TEST(MatchSurface, PosesOfAPartOutOfSizeScatterAsTheirCovariancesSay) {
  expect_scatter_as_stated(solid(ball_on_a_shaft(9.3)), solid(ball_on_a_shaft(9)), 0.01, 5);
}

// A boss too small or too large holds the turn by its middle; from where it touches the model's on one side
// the part would look turned by a degree or two.
TEST(MatchSurface, ABossOfWrongDiameterIsNoWrongPose) {
  const Solid model = solid(capped_cylinder(9));
  const Vec3 side = Vec3(1, 0.4, 0.8).normalized();
  for (const double boss : {8.4, 9.5}) {
    for (uint64_t seed = 1; seed <= 3; ++seed) {
      const Simulated run =
          match_seen_from(solid(capped_cylinder(boss)), model, {side, -side}, kPoses[seed % 2], seed);
      expect_true_pose(run, model.centroid_mm);
      EXPECT_EQ(run.match->found_by, MatchedBy::surface);
      EXPECT_TRUE(run.match->equivalents.empty()) << boss << " " << seed;
    }
  }
}

// What lies off its place as a whole says nothing against the pose; the part upside down does.
TEST(MatchSurface, ABallOutOfSizeDoesNotSpeakAgainstThePose) {
  const Solid model = solid(ball_on_a_shaft(9));
  const RayCaster caster(model);
  const Vec3 amid = 0.5 * (model.box_min_mm + model.box_max_mm);
  const Mat3 half_turn = rotation_from_degrees(180, 0, 0);
  const RigidTransform upside_down{half_turn, amid - half_turn * amid};
  const double gate_mm = kDefaultMaxOffset * (model.box_max_mm - model.box_min_mm).norm();
  for (const double r : {8.2, 8.7, 9.0, 9.3, 9.8}) {
    const Solid part = solid(ball_on_a_shaft(r));
    const RayCaster of_part(part);
    const SurfaceProblemRun run(part, model, caster, of_part, 1);
    const auto against = [&](const RigidTransform& T) {
      return share_against(ray_residuals(run.problem, T, 3000), run.scatter, 0.12, gate_mm);
    };
    EXPECT_LT(against(run.T_scan_model.inverse()), 0.05) << r;
    EXPECT_GT(against(upside_down * run.T_scan_model.inverse()), 0.4) << r;
  }
}

TEST(MatchSurface, AnotherPartsModelIsRefused) {
  const Vec3 side = Vec3(1, 0.4, 0.8).normalized();
  const std::string cylinder = "union() {\n" + post(0, 0, 50, 20, 20) + "}\n",
                    cone = "union() {\n" + post(0, 0, 50, 20, 15) + "}\n";
  for (const auto& [part, model] : {std::pair(ball_on_a_shaft(9), capped_cylinder(9)),
                                    std::pair(cylinder, cone), std::pair(cone, cylinder)}) {
    const Simulated run = match_seen_from(solid(part), solid(model), {side, -side}, kPoses[0], 1);
    if (run.match.ok()) {
      EXPECT_EQ(run.match->found_by, MatchedBy::planes);
    }
  }
}

TEST(MatchSurface, ARoundPartsAxisStaysFree) {
  const Solid model = solid("union() {\n" + post(0, 0, 50, 20, 12) + ball(0, 0, 50, 12) + "}\n");
  const Simulated run = match_seen_from(model, {Vec3(1, 0.4, 0.3).normalized()}, kPoses[0], 1);
  ASSERT_TRUE(run.match.ok()) << run.match.error().message;
  ASSERT_EQ(run.match->undetermined.size(), 1u);
  const FreeDirection& free = run.match->undetermined[0];
  EXPECT_EQ(free.kind, FreeDirection::Kind::rotation);
  EXPECT_GT(std::abs(free.axis.z()), std::cos(0.2 * kDegree));
  EXPECT_LT((free.point_mm - Vec3::UnitZ() * free.point_mm.z()).norm(), 0.1);
  const RigidTransform error = run.match->T_model_part * run.T_scan_model;
  EXPECT_GT((error.R * Vec3::UnitZ()).z(), std::cos(0.2 * kDegree));
  const Vec3 foot = error * Vec3::Zero();
  EXPECT_LT(foot.norm(), 0.2);
}

TEST(MatchSurface, ThreeEqualBallsAboutALargerOneHaveSixPoses) {
  const double c = -0.5, s = std::sqrt(0.75);
  const Solid model = solid("union() {\n" + ball(0, 0, 0, 18) + ball(22, 0, 0, 9) +
                            ball(22 * c, 22 * s, 0, 9) + ball(22 * c, -22 * s, 0, 9) + "}\n");
  std::vector<Vec3> around;
  for (int k = 0; k < 6; ++k) around.push_back((k % 2 ? 1 : -1) * Vec3::Unit(k / 2));
  const Simulated run = match_seen_from(model, around, kPoses[0], 1);
  ASSERT_TRUE(run.match.ok()) << run.match.error().message;
  EXPECT_EQ(run.match->equivalents.size(), 5u);
  EXPECT_TRUE(run.match->undetermined.empty());
  // Each is one of the six: it takes the balls' centres to the balls' centres.
  std::vector<RigidTransform> poses{run.match->T_model_part};
  for (const EquivalentPose& other : run.match->equivalents) poses.push_back(other.T_model_part);
  for (const RigidTransform& pose : poses) {
    const Vec3 image = pose * (run.T_scan_model * Vec3(22, 0, 0));
    double nearest = 1e9;
    for (const Vec3& centre : {Vec3(22, 0, 0), Vec3(22 * c, 22 * s, 0), Vec3(22 * c, -22 * s, 0)})
      nearest = std::min(nearest, (image - centre).norm());
    EXPECT_LT(nearest, 0.1);
  }
}

}  // namespace
}  // namespace tetragauge
