// SPDX-License-Identifier: Apache-2.0
#include "firmware/measure/judge_ray.hpp"

#include "firmware/optics/solve_spot.hpp"
#include "firmware/optics/stage.hpp"

namespace tetragauge {
namespace {

using Scalar = MachineScalar;

constexpr Scalar kFullScaleSum = 65'535;  // two channels
// Ambient light that changed between before and after by more than this many sigmas of its own noise and this
// share of the signal would be left in the result.
constexpr Scalar kAmbientChangeSigmas = 8;
constexpr Scalar kAmbientChangeShare = Scalar(0.02);

struct Channel {
  Scalar light{};     // mean code, ambient taken off
  Scalar ambient{};   // mean code with the laser off
  Scalar change{};    // of the ambient code, after minus before
  Scalar variance{};  // of `light`
};

Channel channel_of(const CameraGeometry<Scalar>& camera, const RaySamples& samples, int index) {
  const Scalar before = samples.mean(Light::kOffBefore, index), on = samples.mean(Light::kOn, index),
               after = samples.mean(Light::kOffAfter, index);
  Channel channel;
  channel.ambient = (before + after) / 2;
  channel.change = after - before;
  channel.light = on - channel.ambient;
  const auto sample_variance = [&](Scalar code) {
    return camera.dark_variance_codes2 + camera.shot_variance_codes * (code > 0 ? code : Scalar(0));
  };
  const Scalar off_noise = (samples.noise(Light::kOffBefore) + samples.noise(Light::kOffAfter)) / 4;
  channel.variance =
      sample_variance(on) * samples.noise(Light::kOn) + sample_variance(channel.ambient) * off_noise;
  return channel;
}

// Position along one axis from its pair of electrodes, and its standard deviation by the derivative of
// h (x2 - x1) / (x2 + x1): 2 h x2 / s^2 and 2 h x1 / s^2.
struct PairPosition {
  Scalar position{}, sigma{}, sum{};
};

PairPosition position_of(const CameraGeometry<Scalar>& camera, const Channel& c1, const Channel& c2) {
  PairPosition pair;
  pair.sum = c1.light + c2.light;
  if (!(pair.sum > 0)) return pair;
  const Scalar h = camera.half_size_mm;
  pair.position = h * (c2.light - c1.light) / pair.sum;
  const Scalar by_1 = 2 * h * c2.light / (pair.sum * pair.sum);
  const Scalar by_2 = 2 * h * c1.light / (pair.sum * pair.sum);
  pair.sigma = square_root(by_1 * by_1 * c1.variance + by_2 * by_2 * c2.variance +
                           camera.position_sigma_mm * camera.position_sigma_mm);
  return pair;
}

struct CameraReading {
  CameraView<Scalar> view;
  Scalar sum{};  // mean of both pairs
  bool saturated = false, ambient = false;
};

CameraReading reading_of(const CameraGeometry<Scalar>& camera, const tg_MeasureConfig& config,
                         const RaySamples& samples, int index) {
  CameraReading reading;
  Channel channels[4];
  Scalar ambient_sum = 0, change = 0, change_variance = 0;
  for (int c = 0; c < 4; ++c) {
    channels[c] = channel_of(camera, samples, 4 * index + c);
    ambient_sum += channels[c].ambient / 2;
    change += channels[c].change / 2;
    const Scalar one =
        camera.dark_variance_codes2 +
        camera.shot_variance_codes * (channels[c].ambient > 0 ? channels[c].ambient : Scalar(0));
    change_variance += one * (samples.noise(Light::kOffBefore) + samples.noise(Light::kOffAfter)) / 4;
  }
  const PairPosition x = position_of(camera, channels[0], channels[1]);
  const PairPosition y = position_of(camera, channels[2], channels[3]);
  reading.sum = (x.sum + y.sum) / 2;

  const uint32_t mine = 0xFu << (4 * index);
  reading.saturated = (samples.on_rail(Light::kOn) & mine) != 0;
  const Scalar change_size = change < 0 ? -change : change;
  reading.ambient = ((samples.on_rail(Light::kOffBefore) | samples.on_rail(Light::kOffAfter)) & mine) != 0 ||
                    ambient_sum >= static_cast<Scalar>(config.ambient_codes) ||
                    (change_size > kAmbientChangeSigmas * square_root(change_variance) &&
                     change_size > kAmbientChangeShare * reading.sum);

  const Scalar edge = camera.half_size_mm;
  const auto on_detector = [edge](Scalar p) { return p > -edge && p < edge; };
  reading.view.used = !reading.saturated && !reading.ambient && x.sum > 0 && y.sum > 0 &&
                      reading.sum >= static_cast<Scalar>(config.weak_sum_codes) && on_detector(x.position) &&
                      on_detector(y.position);
  reading.view.position = {x.position, y.position};
  reading.view.sigma_x_mm = x.sigma;
  reading.view.sigma_y_mm = y.sigma;
  return reading;
}

int32_t rounded(Scalar x) {
  return static_cast<int32_t>(x + (x < 0 ? Scalar(-0.5) : Scalar(0.5)));
}

}  // namespace

BeamRecord judge_ray(const MachineGeometry<Scalar>& machine, const tg_MeasureConfig& config,
                     const StagePlace& stage, const RayPlace& place, const RaySamples& samples) {
  BeamRecord record;
  record.view = place.view;
  record.ray = place.ray;
  record.a_urad = place.a_urad;
  record.b_urad = place.b_urad;
  const auto rejected = [&record](tg_RejectReason reason) {
    record.reason = reason;
    return record;
  };

  const CameraReading readings[2] = {reading_of(machine.camera[0], config, samples, 0),
                                     reading_of(machine.camera[1], config, samples, 1)};
  const CameraView<Scalar> views[2] = {readings[0].view, readings[1].view};
  const int used = (views[0].used ? 1 : 0) + (views[1].used ? 1 : 0);
  if (used == 0) {
    if (readings[0].ambient || readings[1].ambient) return rejected(tg_RejectReason_REJECT_AMBIENT);
    if (readings[0].saturated || readings[1].saturated) return rejected(tg_RejectReason_REJECT_SATURATED);
    return rejected(tg_RejectReason_REJECT_WEAK);
  }

  const Scalar urad = Scalar(1e-6);
  const Beam<Scalar> beam = beam_from_mirrors(machine.galvo, static_cast<Scalar>(place.a_urad) * urad,
                                              static_cast<Scalar>(place.b_urad) * urad);
  const Spot<Scalar> spot = solve_spot(machine, beam, views);
  const Scalar gap_limit =
      static_cast<Scalar>(config.gap_mm) + static_cast<Scalar>(config.gap_sigmas) * spot.gap_sigma_mm;
  if (!spot.solved || !(spot.gap_mm <= gap_limit)) return rejected(tg_RejectReason_REJECT_INCONSISTENT);
  const Vector3<Scalar> in_part =
      part_from_machine(machine.stage, stage.table_rad, stage.slide_mm, spot.point);
  if (!inside(machine.volume, in_part)) return rejected(tg_RejectReason_REJECT_OUTSIDE_VOLUME);

  record.x_um = rounded(spot.point.x * 1000);
  record.y_um = rounded(spot.point.y * 1000);
  record.z_um = rounded(spot.point.z * 1000);
  // At least 0.1 um: a sigma of 0 would make the point infinitely heavy.
  const int32_t sigma_100nm = rounded(spot.sigma_mm * 10'000);
  record.sigma_100nm = sigma_100nm > 0 ? static_cast<uint32_t>(sigma_100nm) : 1u;
  Scalar light = 0;
  for (int i = 0; i < 2; ++i) {
    if (views[i].used) light += readings[i].sum / static_cast<Scalar>(used);
  }
  record.intensity_permille = static_cast<uint32_t>(rounded(light * 1000 / kFullScaleSum));
  if (!place.settled) record.flags |= tg_PointFlag_POINT_UNSETTLED;
  if (used == 1) record.flags |= tg_PointFlag_POINT_ONE_CAMERA;
  if (light < static_cast<Scalar>(config.flag_sum_codes)) record.flags |= tg_PointFlag_POINT_WEAK;
  return record;
}

}  // namespace tetragauge
