// SPDX-License-Identifier: Apache-2.0
// Points, sigmas, mirror angles and step times of seeded input, as checksums: the same lines on every
// processor, or the emulated machine is not the real one. check_same_bits.sh compares.
#include <initializer_list>

#include "firmware/machine_config.hpp"
#include "firmware/measure/judge_ray.hpp"
#include "firmware/motion/move_times.hpp"
#include "firmware/optics/galvo.hpp"
#include "firmware/optics/psd_camera.hpp"
#include "protocol/frame.hpp"

void say(const char* text);  // write_line.cpp

namespace tetragauge {
namespace {

uint32_t seed;  // from 0: the start-up code copies no initialised data
uint32_t draw(uint32_t below) {
  seed = seed * 1664525u + 1013904223u;  // Numerical Recipes
  return (seed >> 8) % below;
}

void say_number(const char* name, uint32_t value) {
  char line[64];
  size_t n = 0;
  for (; name[n] != '\0' && n < 40; ++n) line[n] = name[n];
  line[n++] = ' ';
  for (int shift = 28; shift >= 0; shift -= 4) line[n++] = "0123456789abcdef"[(value >> shift) & 15];
  line[n++] = '\n';
  line[n] = '\0';
  say(line);
}

uint32_t crc_of(uint64_t value, uint32_t crc) {
  uint8_t bytes[8];
  for (int k = 0; k < 8; ++k) bytes[k] = static_cast<uint8_t>(value >> (8 * k));
  return crc32c(bytes, sizeof bytes, crc);
}

// A spot somewhere before the head, seen with noise; now and then covered, dim or bright.
RaySamples samples_of(const MachineGeometry<double>& truth, const RayPlace& place, tg_DetectorType detector) {
  const Beam<double> beam = beam_from_mirrors(truth.galvo, place.a_urad * 1e-6, place.b_urad * 1e-6);
  const double range = 290 + draw(100'000) * 1e-3;
  const Vector3<double> spot = beam.origin + beam.direction * range;
  DetectorPosition<double> at[2];
  double current[2];
  for (int c = 0; c < 2; ++c) {
    bool in_view = false;
    at[c] = project(truth.camera[c], spot, &in_view);
    current[c] = in_view && draw(8) != 0 ? 100 + draw(6'000) : 0;
  }
  RaySamples samples;
  for (const Light light : {Light::kOffBefore, Light::kOn, Light::kOffAfter}) {
    PsdSample burst[20];
    for (PsdSample& sample : burst) {
      for (int c = 0; c < 2; ++c) {
        const double lit = light == Light::kOn ? current[c] : 0;
        const double part = detector == tg_DetectorType_DETECTOR_DUOLATERAL ? 0.5 : 0.25;
        const double half = truth.camera[c].half_size_mm;
        const auto code = [&](double share) {
          return static_cast<int16_t>(300 + lit * share + static_cast<double>(draw(1'000)) / 200);
        };
        sample.camera[c] = {code(part - at[c].x_mm / half / 2), code(part + at[c].x_mm / half / 2),
                            code(part - at[c].y_mm / half / 2), code(part + at[c].y_mm / half / 2)};
      }
    }
    samples.add(light, burst, 20, 32'700, 100);
  }
  return samples;
}

void points(tg_DetectorType detector) {
  MachineConfig config = nominal_config();
  for (tg_CameraConfig& camera : config.camera) {
    camera.detector = detector;
    camera.tilt_x_rad = 0.03;
    camera.tilt_y_rad = -0.02;
    camera.distortion_x[3] = 0.2;
    camera.distortion_y[1] = -0.1;
  }
  const auto truth = geometry_of<double>(config);
  const auto machine = geometry_of<MachineScalar>(config);
  uint32_t crc = 0, good = 0;
  for (uint32_t ray = 0; ray < 1'000; ++ray) {
    const RayPlace place{1, ray, static_cast<int32_t>(draw(160'000)) - 80'000,
                         static_cast<int32_t>(draw(160'000)) - 80'000, true};
    const RaySamples samples = samples_of(truth, place, detector);
    const StagePlace stage{static_cast<MachineScalar>(draw(6'283) * 1e-3),
                           static_cast<MachineScalar>(draw(200))};
    const BeamRecord record = judge_ray(machine, config.measure, stage, place, samples);
    good += record.reason == 0 ? 1 : 0;
    crc = crc_of_beam(record, crc);
  }
  say_number("points", good);
  say_number("records", crc);
  say_number("configuration", config_crc(config));
}

void steps() {
  uint32_t crc = 0;
  for (uint32_t trial = 0; trial < 60; ++trial) {
    const AxisLimits limits{1'000 + draw(199'000), 200'000 + draw(4'000'000),
                            trial % 3 == 0 ? 0 : 1'000'000 + draw(100'000'000)};
    MoveTimes move;
    move.plan(1 + draw(3'000), limits, 84'000'000);
    const uint32_t stop = draw(4'000);
    while (move.given() < move.steps()) {
      crc = crc_of(move.next(), crc);
      if (move.given() == stop) move.stop_after(move.given() + 5);
    }
  }
  say_number("steps", crc);
}

}  // namespace
}  // namespace tetragauge

int main() {
  tetragauge::points(tg_DetectorType_DETECTOR_DUOLATERAL);
  tetragauge::points(tg_DetectorType_DETECTOR_TETRALATERAL);
  tetragauge::steps();
}
