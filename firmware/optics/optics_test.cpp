// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "firmware/optics/nominal_geometry.hpp"
#include "firmware/optics/solve_spot.hpp"
#include "firmware/optics/stage.hpp"

namespace tetragauge {
namespace {

using V = Vector3<double>;

constexpr double kPi = 3.14159265358979323846;

// A machine that nothing is nominal on: all the terms are exercised.
MachineGeometry<double> bent_machine() {
  MachineGeometry<double> machine = nominal_geometry<double>();
  machine.galvo.a_zero_rad = 0.002;
  machine.galvo.b_zero_rad = -0.003;
  machine.galvo.a_scale = 1.01;
  machine.galvo.b_scale = 0.99;
  machine.galvo.a_axis = normalized(machine.galvo.a_axis + V{0.004, -0.002, 0.003});
  machine.galvo.b_normal = normalized(machine.galvo.b_normal + V{-0.003, 0.005, 0.001});
  for (int i = 0; i < 2; ++i) {
    CameraGeometry<double>& camera = machine.camera[i];
    camera.tilt_x_rad = 0.05 - 0.08 * i;
    camera.tilt_y_rad = -0.04 + 0.02 * i;
    camera.centre_x_mm = 0.2;
    camera.centre_y_mm = -0.1;
    for (int k = 0; k < kDistortionTerms; ++k) {
      camera.distortion_x[k] = 0.02 * (k + 1) * (k % 2 ? 1 : -1);
      camera.distortion_y[k] = 0.015 * (7 - k) * (k % 3 ? 1 : -1);
    }
  }
  return machine;
}

TEST(ScalarMath, SineAndCosineAgreeWithTheLibrary) {
  for (double angle = -200; angle < 200; angle += 0.00317) {
    const SinCos<double> d = sin_cos(angle);
    EXPECT_NEAR(d.sin, std::sin(angle), 4.5e-16) << angle;
    EXPECT_NEAR(d.cos, std::cos(angle), 4.5e-16) << angle;
    const float narrow = static_cast<float>(angle);
    const SinCos<float> f = sin_cos(narrow);
    EXPECT_NEAR(f.sin, std::sin(static_cast<double>(narrow)), 2.4e-7) << angle;
    EXPECT_NEAR(f.cos, std::cos(static_cast<double>(narrow)), 2.4e-7) << angle;
  }
}

TEST(Galvo, UndeflectedBeamAimsAtTheAxis) {
  const auto beam = beam_from_mirrors(nominal_geometry<double>().galvo, 0.0, 0.0);
  EXPECT_NEAR(length(cross(V{0, 0, kAimHeightMm} - beam.origin, beam.direction)), 0, 1e-9);
  EXPECT_NEAR(length(V{0, 0, kAimHeightMm} - beam.origin), 350, 1e-9);
  // 35 degrees down: 55 degrees to the normal of a horizontal face.
  EXPECT_NEAR(std::acos(-beam.direction.z) * 180 / kPi, 55, 1e-9);
}

TEST(Galvo, TurnsTheBeamTwiceTheMirrorAngleToTheSideAndUp) {
  const GalvoGeometry<double> galvo = nominal_geometry<double>().galvo;
  const auto straight = beam_from_mirrors(galvo, 0.0, 0.0);
  const auto up = beam_from_mirrors(galvo, 0.0, 0.05);
  EXPECT_NEAR(dot(straight.direction, up.direction), std::cos(0.1), 1e-12);
  EXPECT_GT(up.direction.z, straight.direction.z);
  EXPECT_NEAR(length(up.origin - straight.origin), 0, 1e-12) << "mirror b turns about the spot on it";
  const auto left = beam_from_mirrors(galvo, 0.05, 0.0);
  EXPECT_NEAR(dot(straight.direction, left.direction), std::cos(0.1), 1e-12);
  EXPECT_GT(left.direction.y, 0);
  // The beam leaves mirror a 10 mm above mirror b: the spot on mirror b wanders by 10 mm tan(0.1).
  EXPECT_NEAR(length(left.origin - straight.origin), 10 * std::tan(0.1), 1e-9);
}

// An oracle without mirrors' algebra: a ray is reflected when incidence and reflection make the same angle
// with the turned normal, lie in one plane with it, and the path over the mirror is the shortest one
// (Fermat). Checked for the last mirror.
TEST(Galvo, LastReflectionIsFermats) {
  const GalvoGeometry<double> galvo = bent_machine().galvo;
  const double a = 0.07, b = -0.05;
  const auto beam = beam_from_mirrors(galvo, a, b);
  // The mirror's plane, turned by Rodrigues' formula as a matrix exponential series.
  const double angle = galvo.b_scale * b + galvo.b_zero_rad;
  V term = galvo.b_normal, normal = galvo.b_normal;
  for (int k = 1; k < 20; ++k) {
    term = cross(galvo.b_axis, term) * (angle / k);
    normal = normal + term;
  }
  EXPECT_NEAR(dot(beam.origin - galvo.b_point, normal), 0, 1e-9) << "starts on the mirror";
  const V target = beam.origin + beam.direction * 300.0;
  // Mirror image of the target seen from the incoming beam: it must come from mirror a.
  const V image = target - normal * (2 * dot(target - galvo.b_point, normal));
  const V incoming = normalized(beam.origin - image);  // away from the image: against the travel
  const double to_a = dot(galvo.a_point - beam.origin, incoming);
  EXPECT_LT(length(galvo.a_point - (beam.origin + incoming * to_a)), 0.5)
      << "comes from the spot on mirror a, near its axis";
}

TEST(Galvo, AimsAtEveryPointOfTheVolume) {
  for (const auto& machine : {nominal_geometry<double>(), bent_machine()}) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> side(-71, 71), height(120, 280);
    for (int trial = 0; trial < 500; ++trial) {
      const V point{side(random), side(random), height(random)};
      const auto angles = aim_mirrors(machine.galvo, point);
      ASSERT_TRUE(angles.reached);
      const auto beam = beam_from_mirrors(machine.galvo, angles.a_rad, angles.b_rad);
      EXPECT_LT(length(cross(point - beam.origin, beam.direction)), 1e-6);
    }
    EXPECT_FALSE(aim_mirrors(machine.galvo, V{600, 0, 300}).reached) << "behind the head";
  }
}

TEST(Galvo, MirrorStepForAPitch) {
  const GalvoGeometry<double> galvo = nominal_geometry<double>().galvo;
  const double step = mirror_step_rad(1.0, kHeadDistanceMm);
  const auto beam = beam_from_mirrors(galvo, 0.0, step);
  const V aim{0, 0, kAimHeightMm};
  EXPECT_NEAR(length(cross(aim - beam.origin, beam.direction)), 1.0, 1e-4);
}

TEST(PsdCamera, SpotOnItsAxisIsInTheMiddle) {
  const auto machine = nominal_geometry<double>();
  for (const auto& camera : machine.camera) {
    bool in_view = false;
    const auto at = project(camera, V{0, 0, kAimHeightMm}, &in_view);
    EXPECT_TRUE(in_view);
    EXPECT_NEAR(at.x_mm, 0, 1e-12);
    EXPECT_NEAR(at.y_mm, 0, 1e-12);
    // Similar triangles by hand: 10 mm sideways at 350 / cos 22.5 degrees, f = 35.
    const V axis = cross(camera.x_axis, camera.y_axis);
    const V spot = camera.centre + axis * 378.838 + camera.x_axis * 10.0 - camera.y_axis * 4.0;
    const auto off = project(camera, spot, &in_view);
    EXPECT_NEAR(off.x_mm, 350.0 / 378.838, 1e-9);
    EXPECT_NEAR(off.y_mm, -140.0 / 378.838, 1e-9);
    project(camera, camera.centre - axis * 100.0, &in_view);
    EXPECT_FALSE(in_view) << "behind the camera";
  }
  const V axis_0 = cross(machine.camera[0].x_axis, machine.camera[0].y_axis);
  const V axis_1 = cross(machine.camera[1].x_axis, machine.camera[1].y_axis);
  EXPECT_NEAR(std::acos(dot(axis_0, axis_1)) * 180 / kPi, 45, 1e-9);
}

TEST(PsdCamera, RayGoesThroughWhatWasProjected) {
  const auto machine = bent_machine();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> side(-60, 60);
  for (int trial = 0; trial < 500; ++trial) {
    const V point{side(random), side(random), 200 + side(random)};
    for (const auto& camera : machine.camera) {
      bool in_view = false;
      const auto at = project(camera, point, &in_view);
      const auto ray = ray_from_detector(camera, at);
      EXPECT_LT(length(cross(point - ray.origin, normalized(ray.direction))), 1e-8);
    }
  }
}

TEST(PsdCamera, DerivativesAgreeWithNumericalOnes) {
  // Without distortion: n_x and n_y are derivatives of the ideal position.
  auto machine = bent_machine();
  std::mt19937 random(8);
  std::uniform_real_distribution<double> side(-60, 60);
  for (auto& camera : machine.camera) {
    for (int k = 0; k < kDistortionTerms; ++k) camera.distortion_x[k] = camera.distortion_y[k] = 0;
    for (int trial = 0; trial < 100; ++trial) {
      const V point{side(random), side(random), 200 + side(random)};
      bool in_view = false;
      const auto ray = ray_from_detector(camera, project(camera, point, &in_view));
      const double t = dot(point - ray.origin, ray.direction) / dot(ray.direction, ray.direction);
      const double h = 1e-4;
      const V steps[3] = {{h, 0, 0}, {0, h, 0}, {0, 0, h}};
      const double nx[3] = {ray.n_x.x, ray.n_x.y, ray.n_x.z}, ny[3] = {ray.n_y.x, ray.n_y.y, ray.n_y.z};
      for (int k = 0; k < 3; ++k) {
        const auto plus = project(camera, point + steps[k], &in_view);
        const auto minus = project(camera, point - steps[k], &in_view);
        EXPECT_NEAR(nx[k] / t, (plus.x_mm - minus.x_mm) / (2 * h), 1e-8);
        EXPECT_NEAR(ny[k] / t, (plus.y_mm - minus.y_mm) / (2 * h), 1e-8);
      }
    }
  }
}

TEST(PsdCamera, SlopesOfTheDistortionAgreeWithNumericalOnes) {
  const auto machine = bent_machine();
  std::mt19937 random(10);
  std::uniform_real_distribution<double> place(-9.5, 9.5);
  for (const auto& camera : machine.camera) {
    const auto axes = detail::detector_axes(camera);
    for (int trial = 0; trial < 200; ++trial) {
      const DetectorPosition<double> at{place(random), place(random)};
      const auto ray = ray_from_detector(camera, at);
      const double h = 1e-5;
      const V by_x = (ray_from_detector(camera, {at.x_mm + h, at.y_mm}).direction -
                      ray_from_detector(camera, {at.x_mm - h, at.y_mm}).direction) *
                     (0.5 / h);
      const V by_y = (ray_from_detector(camera, {at.x_mm, at.y_mm + h}).direction -
                      ray_from_detector(camera, {at.x_mm, at.y_mm - h}).direction) *
                     (0.5 / h);
      EXPECT_LT(length(by_x - (axes.x * ray.x_by_x + axes.y * ray.y_by_x)), 1e-8);
      EXPECT_LT(length(by_y - (axes.x * ray.x_by_y + axes.y * ray.y_by_y)), 1e-8);
    }
  }
}

// An axis that stands aside of the origin and leans, a slide that leans another way.
StageGeometry<double> bent_stage() {
  StageGeometry<double> stage = nominal_geometry<double>().stage;
  stage.axis_point = {0.7, -0.4, 0.2};
  stage.axis_direction = normalized(V{0.02, -0.03, 1});
  stage.slide_direction = normalized(V{-0.01, 0.004, 1});
  return stage;
}

TEST(Stage, TurnsAboutAnAxisThatStandsAsideAndLeans) {
  const auto stage = bent_stage();
  std::mt19937 random(12);
  std::uniform_real_distribution<double> side(-50, 50), angle(-kPi, kPi), height(0, 300);
  for (int trial = 0; trial < 200; ++trial) {
    const V part{side(random), side(random), side(random) + 100};
    const double table = angle(random), slide = height(random);
    const V is = machine_from_part(stage, table, slide, part);
    // By a frame of the axis: the height along it stays, the plane across it turns.
    const V w = stage.axis_direction, u = normalized(cross(w, V{1, 0, 0})), v = cross(w, u);
    const double x = dot(part, u), y = dot(part, v);
    const V should = stage.axis_point + stage.slide_direction * slide + w * dot(part, w) +
                     u * (x * std::cos(table) - y * std::sin(table)) +
                     v * (x * std::sin(table) + y * std::cos(table));
    EXPECT_LT(length(is - should), 1e-11);
    EXPECT_LT(length(part_from_machine(stage, table, slide, is) - part), 1e-11);
    // Points of the axis itself do not move.
    EXPECT_LT(length(machine_from_part(stage, table, 0.0, w * 80.0) - (stage.axis_point + w * 80.0)), 1e-11);
  }
}

TEST(Stage, TurnsCounterClockwiseAndRises) {
  const auto stage = nominal_geometry<double>().stage;
  const V p = machine_from_part(stage, kPi / 2, 50.0, V{10, 0, 3});
  EXPECT_NEAR(p.x, 0, 1e-12);
  EXPECT_NEAR(p.y, 10, 1e-12);
  EXPECT_NEAR(p.z, 53, 1e-12);
  const V back = part_from_machine(stage, kPi / 2, 50.0, p);
  EXPECT_NEAR(length(back - V{10, 0, 3}), 0, 1e-12);
}

// ---------------------------------------------------------------- the spot

template <class Scalar>
CameraView<Scalar> seen(const MachineGeometry<double>& truth, int i, const V& point) {
  CameraView<Scalar> view;
  bool in_view = false;
  const auto at = project(truth.camera[i], point, &in_view);
  view.used = in_view;
  view.position = {static_cast<Scalar>(at.x_mm), static_cast<Scalar>(at.y_mm)};
  view.sigma_x_mm = view.sigma_y_mm = static_cast<Scalar>(0.0008);
  return view;
}

// Every point of the working volume, where some slide height puts it in front of the head: machine heights
// within 50 mm of the aim point, all around the axis.
template <class Visit>
void over_the_volume(const MachineGeometry<double>& machine, Visit visit) {
  for (int table = 0; table < 8; ++table) {
    for (double x = -50; x <= 50; x += 20) {
      for (double y = -50; y <= 50; y += 20) {
        for (double z = 0; z <= 200; z += 25) {
          for (double offset = -50; offset <= 50; offset += 25) {
            const double slide = kAimHeightMm + offset - z;
            if (slide < 0 || slide > 300) continue;
            visit(machine_from_part(machine.stage, table * kPi / 4 + 0.1, slide, V{x, y, z}));
          }
        }
      }
    }
  }
}

MachineGeometry<float> narrowed_machine(const MachineGeometry<double>& from) {
  MachineGeometry<float> to;
  const auto f = [](double x) { return static_cast<float>(x); };
  const GalvoGeometry<double>& g = from.galvo;
  to.galvo = {narrowed<float>(g.beam_point),
              narrowed<float>(g.beam_direction),
              narrowed<float>(g.a_point),
              narrowed<float>(g.a_axis),
              narrowed<float>(g.a_normal),
              narrowed<float>(g.b_point),
              narrowed<float>(g.b_axis),
              narrowed<float>(g.b_normal),
              f(g.a_zero_rad),
              f(g.b_zero_rad),
              f(g.a_scale),
              f(g.b_scale),
              f(g.direction_sigma_rad)};
  for (int i = 0; i < 2; ++i) {
    const CameraGeometry<double>& c = from.camera[i];
    CameraGeometry<float>& n = to.camera[i];
    n.centre = narrowed<float>(c.centre);
    n.x_axis = narrowed<float>(c.x_axis);
    n.y_axis = narrowed<float>(c.y_axis);
    n.focal_mm = f(c.focal_mm);
    n.tilt_x_rad = f(c.tilt_x_rad);
    n.tilt_y_rad = f(c.tilt_y_rad);
    n.centre_x_mm = f(c.centre_x_mm);
    n.centre_y_mm = f(c.centre_y_mm);
    n.half_size_mm = f(c.half_size_mm);
    for (int k = 0; k < kDistortionTerms; ++k) {
      n.distortion_x[k] = f(c.distortion_x[k]);
      n.distortion_y[k] = f(c.distortion_y[k]);
    }
  }
  return to;
}

template <class Scalar>
double worst_round_trip_mm(const MachineGeometry<double>& truth, const MachineGeometry<Scalar>& machine,
                           bool first, bool second) {
  double worst = 0;
  over_the_volume(truth, [&](const V& point) {
    const auto angles = aim_mirrors(truth.galvo, point);
    ASSERT_TRUE(angles.reached);
    // Within 10 degrees mechanical, the mirrors' limit.
    ASSERT_LT(std::abs(angles.a_rad), 0.1745);
    ASSERT_LT(std::abs(angles.b_rad), 0.1745);
    CameraView<Scalar> views[2] = {seen<Scalar>(truth, 0, point), seen<Scalar>(truth, 1, point)};
    ASSERT_TRUE(views[0].used || views[1].used);
    views[0].used &= first;
    views[1].used &= second;
    if (!views[0].used && !views[1].used) return;
    const auto beam = beam_from_mirrors(machine.galvo, static_cast<Scalar>(angles.a_rad),
                                        static_cast<Scalar>(angles.b_rad));
    const auto spot = solve_spot(machine, beam, views);
    ASSERT_TRUE(spot.solved);
    const V error{spot.point.x - point.x, spot.point.y - point.y, spot.point.z - point.z};
    worst = std::max(worst, length(error));
  });
  return worst;
}

TEST(SolveSpot, InvertsProjectionOverTheWholeVolume) {
  auto crooked = bent_machine();
  crooked.stage = bent_stage();
  for (const auto& machine : {nominal_geometry<double>(), bent_machine(), crooked}) {
    EXPECT_LT(worst_round_trip_mm(machine, machine, true, true), 0.001);
    EXPECT_LT(worst_round_trip_mm(machine, machine, true, false), 0.001);
    EXPECT_LT(worst_round_trip_mm(machine, machine, false, true), 0.001);
  }
}

// The machine computes in float: what that costs. docs/machine.md names the figure; 2 um are far below a
// spot's sigma.
TEST(SolveSpot, FloatIsGoodEnough) {
  const double both = worst_round_trip_mm(nominal_geometry<double>(), nominal_geometry<float>(), true, true);
  const double one = worst_round_trip_mm(nominal_geometry<double>(), nominal_geometry<float>(), true, false);
  std::printf("worst error of float over the volume: %.2f um, with one camera %.2f um\n", both * 1000,
              one * 1000);
  EXPECT_LT(both, 0.001);
  EXPECT_LT(one, 0.001);
  // A machine that nothing is nominal on loses no more.
  const auto bent = worst_round_trip_mm(bent_machine(), narrowed_machine(bent_machine()), true, true);
  std::printf("the same of a bent machine: %.2f um\n", bent * 1000);
  EXPECT_LT(bent, 0.001);
}

TEST(SolveSpot, SigmaAndGapAreThoseOfRepeatedMeasurements) {
  const auto machine = bent_machine();
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0, 1);
  const V points[] = {{0, 0, 200}, {50, 40, 230}, {-60, -20, 160}, {30, -60, 250}};
  for (int cameras = 1; cameras <= 3; ++cameras) {
    for (const V& point : points) {
      const auto angles = aim_mirrors(machine.galvo, point);
      const auto believed = beam_from_mirrors(machine.galvo, angles.a_rad, angles.b_rad);
      V u, v;
      detail::across(believed.direction, &u, &v);
      const double range = length(point - believed.origin);
      double sum2 = 0, sigma = 0;
      int over_8_sigma = 0;
      const int trials = 4000;
      for (int trial = 0; trial < trials; ++trial) {
        // The beam really goes a little elsewhere, and the spot with it.
        const double s = machine.galvo.direction_sigma_rad * range;
        const V spot_at = point + u * (s * noise(random)) + v * (s * noise(random));
        CameraView<double> views[2];
        for (int i = 0; i < 2; ++i) {
          views[i] = seen<double>(machine, i, spot_at);
          views[i].sigma_x_mm = 0.0006 + 0.0004 * i;
          views[i].sigma_y_mm = 0.0009;
          views[i].position.x_mm += views[i].sigma_x_mm * noise(random);
          views[i].position.y_mm += views[i].sigma_y_mm * noise(random);
          views[i].used = (cameras >> i) & 1;
        }
        const auto spot = solve_spot(machine, believed, views);
        ASSERT_TRUE(spot.solved);
        const double error = dot(spot.point - point, believed.direction);
        sum2 += error * error;
        sigma = spot.sigma_mm;
        if (spot.gap_mm > 8 * spot.gap_sigma_mm) ++over_8_sigma;
      }
      // The standard deviation of an estimate from 4000 draws is 1.1 %.
      EXPECT_NEAR(std::sqrt(sum2 / trials) / sigma, 1, 0.04) << "cameras " << cameras;
      EXPECT_EQ(over_8_sigma, 0);
    }
  }
}

TEST(SolveSpot, AMisplacedCameraOpensTheGap) {
  const auto machine = nominal_geometry<double>();
  const V point{10, 5, 210};
  const auto angles = aim_mirrors(machine.galvo, point);
  const auto beam = beam_from_mirrors(machine.galvo, angles.a_rad, angles.b_rad);
  CameraView<double> views[2] = {seen<double>(machine, 0, point), seen<double>(machine, 1, point)};
  views[0].position.y_mm += 0.1;  // across the plane of triangulation: about 1 mm at the spot
  const auto spot = solve_spot(machine, beam, views);
  EXPECT_GT(spot.gap_mm, 0.3);
  EXPECT_GT(spot.gap_mm, 8 * spot.gap_sigma_mm);
}

TEST(SolveSpot, NoSolutionRatherThanNonsense) {
  const auto machine = nominal_geometry<double>();
  const auto beam = beam_from_mirrors(machine.galvo, 0.0, 0.0);
  CameraView<double> none[2];
  EXPECT_FALSE(solve_spot(machine, beam, none).solved);
  // A camera standing in the beam and looking along it cannot triangulate.
  auto along = machine;
  along.camera[0].centre = beam.origin;
  along.camera[0].x_axis = V{0, 1, 0};
  along.camera[0].y_axis = cross(beam.direction, V{0, 1, 0});
  CameraView<double> views[2];
  views[0].used = true;
  views[0].sigma_x_mm = views[0].sigma_y_mm = 0.001;
  EXPECT_FALSE(solve_spot(along, beam, views).solved);
  const double nan = std::nan("");
  views[0].position = {nan, 0};
  EXPECT_FALSE(solve_spot(machine, beam, views).solved);
}

}  // namespace
}  // namespace tetragauge
