// SPDX-License-Identifier: GPL-3.0-or-later
// Points of the emulated machine against the analytic part they were measured on.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>

#include "host/session/default_plan.hpp"
#include "host/session/emulated_session.hpp"
#include "host/solid/ray_caster.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {
namespace {

struct FaceStatistics {
  size_t points = 0;
  double sum_mm = 0, sum_z = 0, sum_z2 = 0;

  double mean_mm() const { return sum_mm / static_cast<double>(points); }
  double z_deviation() const {
    const double n = static_cast<double>(points), mean = sum_z / n;
    return std::sqrt(sum_z2 / n - mean * mean);
  }
};

// The part as it stands: centre of its bounding box on the axis, lowest point on the table, then shifted.
Solid standing(const std::filesystem::path& part, const Mat3& R, const Vec3& shift = Vec3::Zero()) {
  const auto model = read_solid(part);
  EXPECT_TRUE(model) << model.error().message;
  const Solid turned = transformed(*model, {R, Vec3::Zero()});
  const Vec3 centre = 0.5 * (turned.box_min_mm + turned.box_max_mm);
  return transformed(turned,
                     {Mat3::Identity(), Vec3(-centre.x(), -centre.y(), -turned.box_min_mm.z()) + shift});
}

// Eight points around `centre`, across `axis`.
std::array<Vec3, 8> ring(const Vec3& centre, const Vec3& axis, double radius_mm) {
  const auto [u, v] = tangent_frame(axis);
  std::array<Vec3, 8> points;
  for (size_t k = 0; k < points.size(); ++k) {
    const double angle = static_cast<double>(k) * std::acos(-1.0) / 4;
    points[k] = centre + radius_mm * (std::cos(angle) * u + std::sin(angle) * v);
  }
  return points;
}

// All around the point on the face there is material below and air above.
bool away_from_edges(const RayCaster& part, const Vec3& on_face, const Vec3& normal) {
  constexpr double kMargin_mm = 1.5;
  for (const Vec3& at : ring(on_face, normal, kMargin_mm)) {
    if (!part.inside(at - 0.01 * normal) || part.inside(at + 0.01 * normal)) return false;
  }
  return on_face.z() > kMargin_mm;
}

// From the eye either the whole spot is seen or nothing of it: no edge elsewhere cuts through it.
bool whole_or_hidden(const RayCaster& part, const Vec3& on_face, const Vec3& normal, const Vec3& eye) {
  constexpr double kSpot_mm = 0.5;
  size_t hidden = 0;
  for (const Vec3& at : ring(on_face + 0.01 * normal, normal, kSpot_mm))
    hidden += part.occluded(at, eye) ? 1 : 0;
  return hidden == 0 || hidden == 8;
}

// Lenses in the part frame, as the machine is drawn: on the plate 350 mm from the point aimed at, which is
// tilted 35 degrees, where lines through that point at 22.5 degrees to the middle cut it.
std::array<Vec3, 2> lenses(const PlannedView& view) {
  const double degree = std::acos(-1.0) / 180;
  const double aside_mm = 350 * std::tan(22.5 * degree);
  const Vec3 head(350 * std::cos(35 * degree), 0, 200 + 350 * std::sin(35 * degree) - view.slide_mm);
  const Mat3 turn_back = rotation_from_degrees(0, 0, -view.table_deg);
  return {turn_back * (head + aside_mm * Vec3::UnitY()), turn_back * (head - aside_mm * Vec3::UnitY())};
}

// By the face's id: points on it that no edge of the part, near or far, disturbs.
std::map<int, FaceStatistics> compare(const Scan& scan, const ScanPlan& plan, const Solid& part,
                                      double reach_mm) {
  const RayCaster caster(part);
  std::map<int, FaceStatistics> statistics;
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vec3 ray = scan.ray_direction(i);
    for (size_t f = 0; f < part.faces().size(); ++f) {
      const Face& face = part.faces()[f];
      const double distance = face.normal.dot(scan.points[i]) - face.d_mm;
      const double across = -face.normal.dot(ray);
      if (std::abs(distance) > reach_mm || across < 0.1) continue;
      const Vec3 on_face = scan.points[i] - distance * face.normal;
      const auto hit = caster.first_hit(on_face + face.normal, -face.normal);
      if (!hit || hit->face != static_cast<int>(f) || !away_from_edges(caster, on_face, face.normal))
        continue;
      const auto eyes = lenses(plan.views[scan.view[i]]);
      if (!whole_or_hidden(caster, on_face, face.normal, eyes[0]) ||
          !whole_or_hidden(caster, on_face, face.normal, eyes[1]) ||
          !whole_or_hidden(caster, on_face, face.normal, scan.ray_origins[i])) {
        continue;
      }
      FaceStatistics& s = statistics[face.id];
      const double z = distance / (static_cast<double>(scan.sigma_mm[i]) * across);
      ++s.points;
      s.sum_mm += distance;
      s.sum_z += z;
      s.sum_z2 += z * z;
      break;
    }
  }
  return statistics;
}

void expect_honest(const std::map<int, FaceStatistics>& faces) {
  for (const auto& [id, s] : faces) {
    std::printf("face %2d: %5zu points, mean distance %7.4f mm, distance / sigma %.3f\n", id, s.points,
                s.mean_mm(), s.z_deviation());
    // The standard error of a standard deviation, 1 / sqrt(2 n), is then under 3 %.
    EXPECT_GT(s.points, 600u) << id;
    EXPECT_LT(std::abs(s.mean_mm()), 0.02) << id;
    EXPECT_GT(s.z_deviation(), 0.9) << id;
    EXPECT_LT(s.z_deviation(), 1.1) << id;
  }
}

Result<MeasuredScan> scan_box(const EmulatedMachineOptions& options) {
  auto session = start_session(options);
  if (!session) return session.error();
  return run_scan(*session->link, plan_all_round(2));
}

TEST(ScanAccuracy, BoxPointsLieOnItsFacesWithHonestSigmas) {
  const auto part = box_file();
  const auto measured = scan_box({.part = part});
  ASSERT_TRUE(measured) << measured.error().message;
  const auto faces = compare(measured->scan, plan_all_round(2), standing(part, Mat3::Identity()), 0.5);
  ASSERT_EQ(faces.size(), 5u);  // all but the one it stands on
  expect_honest(faces);
}

// Places in the working volume, up to its limits: 100 x 100 mm, 200 mm high.
struct Placed {
  const char* name;
  bool wedge;  // 45 degrees, 34 x 30 mm, 34 high; otherwise a box 30 x 26 x 36
  Vec3 shift_mm;
};

class ScanAccuracyInTheVolume : public ::testing::TestWithParam<Placed> {};

TEST_P(ScanAccuracyInTheVolume, PointsLieOnTheFacesWithHonestSigmas) {
  const Placed& placed = GetParam();
  const auto part =
      placed.wedge
          ? temporary_file("wedge.csg",
                           "multmatrix([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) {\n"
                           "  linear_extrude(height = 30, center = true, convexity = 1, scale = [1, 1]) {\n"
                           "    polygon(points = [[0, 0], [34, 0], [0, 34]], paths = undef, convexity = 1);\n"
                           "  }\n}\n")
          : temporary_file("small_box.csg", "cube(size = [30, 26, 36], center = false);\n");
  const Vec3& t = placed.shift_mm;
  ScanPlan plan = plan_all_round(placed.wedge ? 1.1 : 1.4);
  for (PlannedView& view : plan.views) {
    view.slide_mm = 200 - (t.z() + 17);
    // Where the part has turned to, seen from the head that looks 35 degrees down. Half its diagonal is 25
    // mm.
    const Vec3 at = rotation_from_degrees(0, 0, view.table_deg) * Vec3(t.x(), t.y(), 0);
    const double up = -at.x() * std::sin(35 * std::acos(-1.0) / 180), reach = 33;
    view.window = {.y_min_mm = at.y() - reach,
                   .y_max_mm = at.y() + reach,
                   .up_min_mm = up - reach,
                   .up_max_mm = up + reach};
  }
  auto session = start_session({.part = part,
                                .place = "0,0,0," + std::to_string(t.x()) + "," + std::to_string(t.y()) +
                                         "," + std::to_string(t.z())});
  ASSERT_TRUE(session) << session.error().message;
  const auto measured = run_scan(*session->link, plan);
  ASSERT_TRUE(measured) << measured.error().message;
  const auto faces = compare(measured->scan, plan, standing(part, Mat3::Identity(), t), 0.5);
  ASSERT_EQ(faces.size(), placed.wedge ? 4u : 5u);  // all but the one it stands on
  expect_honest(faces);
}

INSTANTIATE_TEST_SUITE_P(Places, ScanAccuracyInTheVolume,
                         ::testing::Values(Placed{"BoxAtOneSide", false, Vec3(34, 0, 0)},
                                           Placed{"BoxHighInACorner", false, Vec3(-33, 36, 160)},
                                           Placed{"WedgeInTheMiddle", true, Vec3(0, 0, 60)},
                                           Placed{"WedgeHighAtOneSide", true, Vec3(0, -34, 164)}),
                         [](const auto& info) { return info.param.name; });

TEST(ScanAccuracy, StaircaseOnItsEndByTheDefaultPlan) {
  const std::filesystem::path part = TETRAGAUGE_EXAMPLES "/staircase/nominal.csg";
  auto session = start_session({.part = part, .place = "90,0,0,0,0,0"});
  ASSERT_TRUE(session) << session.error().message;
  const auto plan = default_plan(*session->link, {.pitch_mm = 0.9});
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->views.size(), 8u);
  const auto measured = run_scan(*session->link, *plan);
  ASSERT_TRUE(measured) << measured.error().message;
  const auto faces = compare(measured->scan, *plan, standing(part, rotation_from_degrees(90, 0, 0)), 0.5);
  EXPECT_EQ(faces.size(), 14u);
  expect_honest(faces);
}

// The hand calculation of docs/machine.md: a matt plate at the point aimed at, turned away from the beam. It
// is so large that the raster ends well within it.
TEST(ScanAccuracy, SigmaIsTheHandCalculation) {
  const auto part = temporary_file("plate.csg", "cube(size = [10, 60, 60], center = true);\n");
  const struct {
    double incidence_deg, turn_deg, sigma_mm;
  } kCases[] = {{0, -35, 0.0276}, {30, -5, 0.0315}, {60, 25, 0.0533}};
  for (const auto& c : kCases) {
    const Mat3 R = rotation_from_degrees(0, c.turn_deg, 0);
    const Solid truth = standing(part, R);
    auto session = start_session({.part = part, .place = "0," + std::to_string(c.turn_deg) + ",0,0,0,0"});
    ASSERT_TRUE(session) << session.error().message;
    PlannedView view;
    view.slide_mm = 200 - 0.5 * truth.box_max_mm.z();
    view.window = {.y_min_mm = -8, .y_max_mm = 8, .up_min_mm = -6, .up_max_mm = 6};
    view.pitch_mm = 0.5;
    const auto measured = run_scan(*session->link, {.views = {view}});
    ASSERT_TRUE(measured) << measured.error().message;
    const Vec3 normal = R * Vec3::UnitX();
    const double d_mm = normal.dot(Vec3(0, 0, 0.5 * truth.box_max_mm.z())) + 5;
    double sum2 = 0, reported = 0;
    const Scan& scan = measured->scan;
    ASSERT_GT(scan.size(), 600u);
    for (size_t i = 0; i < scan.size(); ++i) {
      const double along_ray = (normal.dot(scan.points[i]) - d_mm) / normal.dot(scan.ray_direction(i));
      sum2 += along_ray * along_ray;
      reported += static_cast<double>(scan.sigma_mm[i]);
    }
    const double n = static_cast<double>(scan.size());
    const double scatter = std::sqrt(sum2 / n);
    std::printf("incidence %2.0f degrees: scatter %.4f mm, reported %.4f mm, by hand %.4f mm\n",
                c.incidence_deg, scatter, reported / n, c.sigma_mm);
    EXPECT_NEAR(scatter / c.sigma_mm, 1, 0.2) << c.incidence_deg;
    EXPECT_NEAR(reported / n / c.sigma_mm, 1, 0.2) << c.incidence_deg;
  }
}

// 300 points/s at +-0.1 mm (95 %) on a matt face within 30 degrees of the beam.
TEST(ScanAccuracy, ThreeHundredPointsASecondWithinATenthOfAMillimetre) {
  const auto part = temporary_file("plate.csg", "cube(size = [10, 40, 40], center = true);\n");
  for (const double incidence_deg : {0.0, 30.0}) {
    const Mat3 R = rotation_from_degrees(0, incidence_deg - 35, 0);
    const Solid truth = standing(part, R);
    const auto trace = temporary_file("rate.csv", "");
    PlannedView view;
    view.slide_mm = 200 - 0.5 * truth.box_max_mm.z();
    view.window = {.y_min_mm = -8, .y_max_mm = 8, .up_min_mm = -6, .up_max_mm = 6};
    view.pitch_mm = 0.5;
    std::optional<MeasuredScan> measured;
    {
      auto session = start_session(
          {.part = part, .place = "0," + std::to_string(incidence_deg - 35) + ",0,0,0,0", .trace = trace});
      ASSERT_TRUE(session) << session.error().message;
      auto scan = run_scan(*session->link, {.views = {view}});
      ASSERT_TRUE(scan) << scan.error().message;
      measured = std::move(*scan);
    }
    // From the first light to the last, in the machine's own time.
    std::ifstream lines(trace);
    double first_s = -1, last_s = 0;
    size_t lights = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.find(",laser,on") == std::string::npos) continue;
      last_s = 1e-9 * std::stod(line);
      if (first_s < 0) first_s = last_s;
      ++lights;
    }
    ASSERT_GT(lights, 600u);
    EXPECT_GE(static_cast<double>(lights - 1) / (last_s - first_s), 300);

    const Vec3 normal = R * Vec3::UnitX();
    const double d_mm = normal.dot(Vec3(0, 0, 0.5 * truth.box_max_mm.z())) + 5;
    ASSERT_GT(measured->scan.size(), 600u);
    const auto within = std::count_if(measured->scan.points.begin(), measured->scan.points.end(),
                                      [&](const Vec3& p) { return std::abs(normal.dot(p) - d_mm) <= 0.1; });
    EXPECT_GE(static_cast<double>(within), 0.95 * static_cast<double>(measured->scan.size()))
        << incidence_deg;
  }
}

TEST(ScanAccuracy, SeesGeometryThatIsNotWhatItIsBelievedToBe) {
  const auto part = box_file();
  // Both cameras squint: each turned and shifted so that its image of every point moves the same way. Then
  // their lenses distort besides.
  const char* const kWorlds[] = {
      R"({"camera_1": {"turn_deg": [0, 0.02, 0], "shift_mm": [0, -0.05, 0]},
          "camera_2": {"turn_deg": [0, -0.02, 0], "shift_mm": [0, 0.05, 0]}})",
      R"({"camera_1": {"turn_deg": [0, 0.02, 0], "shift_mm": [0, -0.05, 0], "distortion": 0.005},
          "camera_2": {"turn_deg": [0, -0.02, 0], "shift_mm": [0, 0.05, 0], "distortion": 0.005}})"};
  for (const char* text : kWorlds) {
    const auto measured = scan_box({.part = part, .world = temporary_file("cameras_off.json", text)});
    ASSERT_TRUE(measured) << measured.error().message;
    double worst = 0;
    for (const auto& [id, s] :
         compare(measured->scan, plan_all_round(2), standing(part, Mat3::Identity()), 2.0)) {
      worst = std::max(worst, std::abs(s.mean_mm()));
    }
    std::printf("worst face %.2f mm off\n", worst);
    EXPECT_GT(worst, 0.1);
  }
}

TEST(ScanAccuracy, MachineBuiltWrongSaysSoAndGivesNoPoints) {
  for (const char* turn : {"[0.5, 0, 0]", "[0, 0.5, 0]"}) {
    const auto world =
        temporary_file("built_wrong.json", std::string(R"({"camera_2": {"turn_deg": )") + turn + "}}");
    const auto measured = scan_box({.part = box_file(), .world = world});
    ASSERT_FALSE(measured) << turn;
    EXPECT_EQ(measured.error().kind, ErrorKind::machine);
    EXPECT_NE(measured.error().message.find("misses its beam"), std::string::npos)
        << measured.error().message;
  }
}

}  // namespace
}  // namespace tetragauge
