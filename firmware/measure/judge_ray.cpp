// SPDX-License-Identifier: Apache-2.0
#include "firmware/measure/judge_ray.hpp"

#include "firmware/optics/solve_spot.hpp"
#include "firmware/optics/stage.hpp"

namespace tetragauge {
namespace {

using Scalar = MachineScalar;

constexpr Scalar kFullScaleCurrent = 65'535;  // two channels
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

// Position along one axis from its pair of electrodes, x = h d / s with d = c2 - c1 and s the photocurrent:
// of the pair (duolateral) or of all four (tetralateral). Its standard deviation by the derivatives of that,
// h (s - d) / s^2 by c2, - h (s + d) / s^2 by c1, and with four electrodes - h d / s^2 by the other two.
struct AxisPosition {
  Scalar position{}, sigma{}, current{};
};

AxisPosition position_of(const CameraGeometry<Scalar>& camera, const Channel (&own)[2],
                         const Channel (&other)[2]) {
  const bool shared = camera.detector == Detector::kTetralateral;
  AxisPosition axis;
  axis.current = own[0].light + own[1].light;
  if (shared) axis.current = axis.current + other[0].light + other[1].light;
  if (!(axis.current > 0)) return axis;
  const Scalar h = camera.half_size_mm, s = axis.current, d = own[1].light - own[0].light;
  axis.position = h * d / s;
  const Scalar by_1 = (s + d) / s, by_2 = (s - d) / s, by_other = d / s;
  Scalar variance = by_1 * by_1 * own[0].variance + by_2 * by_2 * own[1].variance;
  if (shared) variance = variance + by_other * by_other * (other[0].variance + other[1].variance);
  axis.sigma = square_root(h * h / (s * s) * variance + camera.position_sigma_mm * camera.position_sigma_mm);
  return axis;
}

struct CameraReading {
  CameraView<Scalar> view;
  Scalar current{};  // of the photodiode, codes: with two pairs their mean
  bool saturated = false, ambient = false;
};

CameraReading reading_of(const CameraGeometry<Scalar>& camera, const tg_MeasureConfig& config,
                         const RaySamples& samples, int index) {
  CameraReading reading;
  // Of the four codes' sum, how much is the photocurrent: with two pairs, each carries the whole.
  const Scalar share = camera.detector == Detector::kTetralateral ? Scalar(1) : Scalar(0.5);
  Channel channels[2][2];  // x, y
  Scalar ambient_current = 0, change = 0, change_variance = 0;
  for (int c = 0; c < 4; ++c) {
    Channel& channel = channels[c / 2][c % 2];
    channel = channel_of(camera, samples, 4 * index + c);
    ambient_current += channel.ambient * share;
    change += channel.change * share;
    const Scalar one = camera.dark_variance_codes2 +
                       camera.shot_variance_codes * (channel.ambient > 0 ? channel.ambient : Scalar(0));
    change_variance +=
        one * (samples.noise(Light::kOffBefore) + samples.noise(Light::kOffAfter)) * share * share;
  }
  const AxisPosition x = position_of(camera, channels[0], channels[1]);
  const AxisPosition y = position_of(camera, channels[1], channels[0]);
  reading.current = (x.current + y.current) / 2;

  const uint32_t mine = 0xFu << (4 * index);
  reading.saturated = (samples.on_rail(Light::kOn) & mine) != 0;
  const Scalar change_size = change < 0 ? -change : change;
  reading.ambient = ((samples.on_rail(Light::kOffBefore) | samples.on_rail(Light::kOffAfter)) & mine) != 0 ||
                    ambient_current >= static_cast<Scalar>(config.ambient_codes) ||
                    (change_size > kAmbientChangeSigmas * square_root(change_variance) &&
                     change_size > kAmbientChangeShare * reading.current);

  const Scalar edge = camera.half_size_mm;
  const auto on_detector = [edge](Scalar p) { return p > -edge && p < edge; };
  reading.view.used = !reading.saturated && !reading.ambient && x.current > 0 && y.current > 0 &&
                      reading.current >= static_cast<Scalar>(config.weak_sum_codes) &&
                      on_detector(x.position) && on_detector(y.position);
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
    if (views[i].used) light += readings[i].current / static_cast<Scalar>(used);
  }
  record.intensity_permille = static_cast<uint32_t>(rounded(light * 1000 / kFullScaleCurrent));
  if (!place.settled) record.flags |= tg_PointFlag_POINT_UNSETTLED;
  if (used == 1) record.flags |= tg_PointFlag_POINT_ONE_CAMERA;
  if (light < static_cast<Scalar>(config.flag_sum_codes)) record.flags |= tg_PointFlag_POINT_WEAK;
  return record;
}

}  // namespace tetragauge
