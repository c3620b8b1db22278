// SPDX-License-Identifier: Apache-2.0
#include "firmware/machine_config.hpp"

#include "firmware/motion/move_times.hpp"
#include "firmware/optics/nominal_geometry.hpp"
#include "firmware/optics/rotate.hpp"
#include "protocol/message.hpp"

namespace tetragauge {
namespace {

tg_Vector message_of(const Vector3<double>& v) {
  return {v.x, v.y, v.z};
}

template <class Scalar>
Vector3<Scalar> vector_of(const tg_Vector& v) {
  return narrowed<Scalar>({v.x, v.y, v.z});
}

bool finite(double x) {
  return x - x == 0;
}
bool finite(const tg_Vector& v) {
  return finite(v.x) && finite(v.y) && finite(v.z);
}
bool unit(const tg_Vector& v) {
  const double square = v.x * v.x + v.y * v.y + v.z * v.z;
  return square > 0.999999 && square < 1.000001;
}
bool across(const tg_Vector& a, const tg_Vector& b) {
  const double product = a.x * b.x + a.y * b.y + a.z * b.z;
  return product > -1e-6 && product < 1e-6;
}

const char* error_of(const tg_GalvoConfig& galvo) {
  if (!finite(galvo.beam_point_mm) || !finite(galvo.a_point_mm) || !finite(galvo.b_point_mm)) {
    return "galvo: a point is missing or not a number";
  }
  if (!unit(galvo.beam_direction) || !unit(galvo.a_axis) || !unit(galvo.a_normal) || !unit(galvo.b_axis) ||
      !unit(galvo.b_normal)) {
    return "galvo: directions, axes and normals must have length 1";
  }
  if (!(galvo.a_scale > 0.5 && galvo.a_scale < 2 && galvo.b_scale > 0.5 && galvo.b_scale < 2)) {
    return "galvo: scales must lie between 0.5 and 2";
  }
  if (!(galvo.a_zero_urad > -1e5 && galvo.a_zero_urad < 1e5 && galvo.b_zero_urad > -1e5 &&
        galvo.b_zero_urad < 1e5)) {
    return "galvo: zeros must lie within 100,000 urad";
  }
  if (galvo.limit_urad <= 0 || galvo.limit_urad > 196'000) return "galvo: limit_urad must be 1 to 196,000";
  if (!(galvo.direction_sigma_urad > 0 && galvo.direction_sigma_urad < 1e4)) {
    return "galvo: direction_sigma_urad must lie between 0 and 10,000";
  }
  return nullptr;
}

const char* error_of(const tg_CameraConfig& camera) {
  if (camera.index > 1) return "camera: index must be 0 or 1";
  if (!finite(camera.centre_mm)) return "camera: centre is missing or not a number";
  if (!unit(camera.x_axis) || !unit(camera.y_axis) || !across(camera.x_axis, camera.y_axis)) {
    return "camera: axes must have length 1 and be perpendicular";
  }
  if (!(camera.focal_mm > 1 && camera.focal_mm < 1000)) return "camera: focal_mm must lie between 1 and 1000";
  if (!(camera.half_size_mm > 0.5 && camera.half_size_mm < 100)) {
    return "camera: half_size_mm must lie between 0.5 and 100";
  }
  if (!(camera.tilt_x_rad > -0.5 && camera.tilt_x_rad < 0.5 && camera.tilt_y_rad > -0.5 &&
        camera.tilt_y_rad < 0.5)) {
    return "camera: tilts must lie within 0.5 rad";
  }
  if (!finite(camera.centre_x_mm) || !finite(camera.centre_y_mm))
    return "camera: electrical centre is no number";
  if (camera.detector != tg_DetectorType_DETECTOR_DUOLATERAL &&
      camera.detector != tg_DetectorType_DETECTOR_TETRALATERAL) {
    return "camera: detector is of a type unknown to this firmware";
  }
  for (int i = 0; i < kDistortionTerms; ++i) {
    const double x = camera.distortion_x[i], y = camera.distortion_y[i];
    // A tenth of the detector: beyond, inverting the distortion is not certain to converge.
    const double most = camera.half_size_mm / 10;
    if (!(x > -most && x < most && y > -most && y < most))
      return "camera: distortion beyond a tenth of half_size";
  }
  if (!(camera.dark_variance_codes2 > 0 && camera.dark_variance_codes2 < 1e8) ||
      !(camera.shot_variance_codes >= 0 && camera.shot_variance_codes < 1e4) ||
      !(camera.position_sigma_mm >= 0 && camera.position_sigma_mm < 1)) {
    return "camera: noise figures out of range";
  }
  return nullptr;
}

const char* error_of(const tg_AxisMotion& motion) {
  if (motion.min_steps >= motion.max_steps || motion.home_steps > motion.min_steps) {
    return "stage: an axis needs home_steps <= min_steps < max_steps";
  }
  if (motion.speed == 0 || motion.homing_speed == 0 || motion.latch_speed == 0 || motion.speed > 200'000 ||
      motion.homing_speed > 200'000 || motion.latch_speed > motion.homing_speed) {
    return "stage: speeds must lie between 1 and 200,000 steps/s, latch_speed not above homing_speed";
  }
  const uint32_t fastest = motion.speed > motion.homing_speed ? motion.speed : motion.homing_speed;
  if (motion.acceleration == 0 ||
      !(ramp_to_speed({fastest, motion.acceleration, motion.jerk}).duration() <= kLongestSpeedUpS)) {
    return "stage: acceleration and jerk must reach full speed within 4 s";
  }
  if (int64_t{motion.max_steps} - motion.home_steps > kLongestMoveSteps / 2) {
    return "stage: an axis may be 10,000,000 steps long";
  }
  if (motion.backlash_steps > 10'000) return "stage: backlash_steps must be at most 10,000";
  return nullptr;
}

const char* error_of(const tg_StageConfig& stage) {
  if (!finite(stage.axis_point_mm) || !unit(stage.axis_direction) || !unit(stage.slide_direction)) {
    return "stage: axis and slide need a point and directions of length 1";
  }
  if (stage.table_steps_per_turn == 0 || stage.table_steps_per_turn > 10'000'000 ||
      stage.slide_steps_per_m == 0 || stage.slide_steps_per_m > 10'000'000) {
    return "stage: steps per turn and per metre must lie between 1 and 10,000,000";
  }
  const char* table = error_of(stage.table);
  return table ? table : error_of(stage.slide);
}

const char* error_of(const tg_MeasureConfig& measure) {
  if (measure.settle_max_us > 1'000'000 || measure.settle_base_us > measure.settle_max_us ||
      measure.settle_per_mrad_us > 1'000'000 || measure.laser_delay_us > 100'000 ||
      measure.stage_settle_us > 10'000'000) {
    return "measure: settling times out of range";
  }
  if (measure.rail_codes == 0 || measure.rail_codes > 32'768)
    return "measure: rail_codes must be 1 to 32,768";
  if (measure.weak_sum_codes == 0 || measure.flag_sum_codes < measure.weak_sum_codes) {
    return "measure: needs 0 < weak_sum_codes <= flag_sum_codes";
  }
  if (measure.ambient_codes == 0) return "measure: ambient_codes must not be 0";
  if (!(measure.gap_mm >= 0 && measure.gap_mm < 1000) ||
      !(measure.gap_sigmas > 0 && measure.gap_sigmas < 1000)) {
    return "measure: gap_mm and gap_sigmas must lie between 0 and 1000";
  }
  if (measure.misassembled_after == 0) return "measure: misassembled_after must not be 0";
  if (measure.trim_permille > 250) return "measure: trim_permille must be at most 250";
  if (measure.stable_max_us > 1'000'000) return "measure: stable_max_us must be at most 1,000,000";
  return nullptr;
}

const char* error_of(const tg_VolumeConfig& volume) {
  const tg_Vector &low = volume.min_mm, &high = volume.max_mm;
  const bool good = finite(low) && finite(high) && low.x < high.x && low.y < high.y && low.z < high.z;
  return good ? nullptr : "volume: min must be below max";
}

constexpr double kUdegPerTurn = 360e6;

int64_t rounded(double x) {
  return static_cast<int64_t>(x + (x < 0 ? -0.5 : 0.5));
}

// An axis jogged far away without being homed, in a configuration with few steps: as far as a message can
// say.
int32_t saturated(double x) {
  return static_cast<int32_t>(rounded(x > INT32_MAX ? INT32_MAX : x < -INT32_MAX ? -INT32_MAX : x));
}

}  // namespace

MachineConfig nominal_config() {
  constexpr MachineGeometry<double> nominal = nominal_geometry<double>();
  MachineConfig config;

  tg_GalvoConfig& galvo = config.galvo;
  galvo = {true,
           message_of(nominal.galvo.beam_point),
           true,
           message_of(nominal.galvo.beam_direction),
           true,
           message_of(nominal.galvo.a_point),
           true,
           message_of(nominal.galvo.a_axis),
           true,
           message_of(nominal.galvo.a_normal),
           true,
           message_of(nominal.galvo.b_point),
           true,
           message_of(nominal.galvo.b_axis),
           true,
           message_of(nominal.galvo.b_normal),
           0,        // a_zero_urad: of mirror a at 0 V
           0,        // b_zero_urad
           1,        // a_scale: true angle over commanded angle
           1,        // b_scale
           174'533,  // 10 degrees: the beam turns 20
           nominal.galvo.direction_sigma_rad * 1e6};

  for (uint32_t i = 0; i < 2; ++i) {
    const CameraGeometry<double>& from = nominal.camera[i];
    tg_CameraConfig& camera = config.camera[i];
    camera.index = i;
    camera.has_centre_mm = camera.has_x_axis = camera.has_y_axis = true;
    camera.centre_mm = message_of(from.centre);
    camera.x_axis = message_of(from.x_axis);
    camera.y_axis = message_of(from.y_axis);
    camera.focal_mm = from.focal_mm;
    camera.half_size_mm = from.half_size_mm;
    camera.dark_variance_codes2 = from.dark_variance_codes2;
    camera.shot_variance_codes = from.shot_variance_codes;
    camera.position_sigma_mm = from.position_sigma_mm;
  }

  tg_StageConfig& stage = config.stage;
  stage.has_axis_point_mm = stage.has_axis_direction = stage.has_slide_direction = true;
  stage.axis_point_mm = message_of(nominal.stage.axis_point);
  stage.axis_direction = message_of(nominal.stage.axis_direction);
  stage.slide_direction = message_of(nominal.stage.slide_direction);
  stage.table_steps_per_turn = 36'000;  // 0.01 degrees
  stage.slide_steps_per_m = 200'000;    // 5 um
  stage.has_table = stage.has_slide = true;
  // min, max, speed, acceleration, homing, latch, home, backlash, jerk
  stage.table = {-18'000, 36'000, 9'000, 36'000, 9'000, 500, -18'100, 20, 720'000};
  // Homing stops within 4000 (4000 / 100,000 + 100,000 / 4,000,000) / 2 = 130 steps and what a planned stop
  // is ahead: the end switch, 200 below the edge, is not reached.
  stage.slide = {-200, 60'200, 20'000, 100'000, 4'000, 500, -400, 20, 4'000'000};

  // base, per mrad, max, laser, weak, flag, rail, ambient, gap mm, gap sigmas, mis-assembled after, stage,
  // trim, stable codes, stable max
  config.measure = {600, 40, 8'000, 100, 60, 300, 32'700, 40'000, 0.3, 8, 200, 100'000, 100, 0, 0};

  config.volume = {true, message_of(nominal.volume.min), true, message_of(nominal.volume.max)};
  return config;
}

const char* config_error(const tg_Config& part) {
  switch (part.which_part) {
    case tg_Config_galvo_tag:
      return error_of(part.part.galvo);
    case tg_Config_camera_tag:
      return error_of(part.part.camera);
    case tg_Config_stage_tag:
      return error_of(part.part.stage);
    case tg_Config_measure_tag:
      return error_of(part.part.measure);
    case tg_Config_volume_tag:
      return error_of(part.part.volume);
    default:
      return "config: holds no part";
  }
}

void set_part(MachineConfig* config, const tg_Config& part) {
  switch (part.which_part) {
    case tg_Config_galvo_tag:
      config->galvo = part.part.galvo;
      break;
    case tg_Config_camera_tag:
      config->camera[part.part.camera.index] = part.part.camera;
      break;
    case tg_Config_stage_tag:
      config->stage = part.part.stage;
      break;
    case tg_Config_measure_tag:
      config->measure = part.part.measure;
      break;
    case tg_Config_volume_tag:
      config->volume = part.part.volume;
      break;
    default:
      break;
  }
}

bool get_part(const MachineConfig& config, tg_ConfigPart part, tg_Config* out) {
  *out = tg_Config_init_zero;
  switch (part) {
    case tg_ConfigPart_CONFIG_GALVO:
      out->which_part = tg_Config_galvo_tag;
      out->part.galvo = config.galvo;
      return true;
    case tg_ConfigPart_CONFIG_CAMERA_1:
    case tg_ConfigPart_CONFIG_CAMERA_2:
      out->which_part = tg_Config_camera_tag;
      out->part.camera = config.camera[part - tg_ConfigPart_CONFIG_CAMERA_1];
      return true;
    case tg_ConfigPart_CONFIG_STAGE:
      out->which_part = tg_Config_stage_tag;
      out->part.stage = config.stage;
      return true;
    case tg_ConfigPart_CONFIG_MEASURE:
      out->which_part = tg_Config_measure_tag;
      out->part.measure = config.measure;
      return true;
    case tg_ConfigPart_CONFIG_VOLUME:
      out->which_part = tg_Config_volume_tag;
      out->part.volume = config.volume;
      return true;
    default:
      return false;
  }
}

tg_Calibration calibration_of(const MachineConfig& config) {
  tg_Calibration calibration = tg_Calibration_init_zero;
  calibration.has_galvo = calibration.has_camera_1 = calibration.has_camera_2 = true;
  calibration.has_stage = calibration.has_measure = calibration.has_volume = true;
  calibration.galvo = config.galvo;
  calibration.camera_1 = config.camera[0];
  calibration.camera_2 = config.camera[1];
  calibration.stage = config.stage;
  calibration.measure = config.measure;
  calibration.volume = config.volume;
  return calibration;
}

const char* calibration_error(const tg_Calibration& calibration) {
  if (!calibration.has_galvo || !calibration.has_camera_1 || !calibration.has_camera_2 ||
      !calibration.has_stage || !calibration.has_measure || !calibration.has_volume) {
    return "calibration: a part is missing";
  }
  if (calibration.id[0] == '\0') return "calibration: needs an id";
  if (calibration.camera_1.index != 0 || calibration.camera_2.index != 1) {
    return "calibration: camera_1 has index 0, camera_2 index 1";
  }
  const char* errors[] = {error_of(calibration.galvo),    error_of(calibration.camera_1),
                          error_of(calibration.camera_2), error_of(calibration.stage),
                          error_of(calibration.measure),  error_of(calibration.volume)};
  for (const char* error : errors) {
    if (error != nullptr) return error;
  }
  return nullptr;
}

void use_calibration(const tg_Calibration& calibration, MachineConfig* config) {
  config->galvo = calibration.galvo;
  config->camera[0] = calibration.camera_1;
  config->camera[1] = calibration.camera_2;
  config->stage = calibration.stage;
  config->measure = calibration.measure;
  config->volume = calibration.volume;
}

uint32_t config_crc(const MachineConfig& config) {
  uint32_t crc = 0;
  for (int part = tg_ConfigPart_CONFIG_GALVO; part <= tg_ConfigPart_CONFIG_VOLUME; ++part) {
    tg_Config message = tg_Config_init_zero;
    get_part(config, static_cast<tg_ConfigPart>(part), &message);
    uint8_t bytes[kFramePayloadBytes];
    const size_t count = encode_payload(message, bytes);
    crc = crc32c(bytes, count, crc);
  }
  return crc;
}

template <class Scalar>
MachineGeometry<Scalar> geometry_of(const MachineConfig& config) {
  const auto scalar = [](double x) { return static_cast<Scalar>(x); };
  MachineGeometry<Scalar> machine;
  const tg_GalvoConfig& galvo = config.galvo;
  machine.galvo.beam_point = vector_of<Scalar>(galvo.beam_point_mm);
  machine.galvo.beam_direction = vector_of<Scalar>(galvo.beam_direction);
  machine.galvo.a_point = vector_of<Scalar>(galvo.a_point_mm);
  machine.galvo.a_axis = vector_of<Scalar>(galvo.a_axis);
  machine.galvo.a_normal = vector_of<Scalar>(galvo.a_normal);
  machine.galvo.b_point = vector_of<Scalar>(galvo.b_point_mm);
  machine.galvo.b_axis = vector_of<Scalar>(galvo.b_axis);
  machine.galvo.b_normal = vector_of<Scalar>(galvo.b_normal);
  machine.galvo.a_zero_rad = scalar(galvo.a_zero_urad * 1e-6);
  machine.galvo.b_zero_rad = scalar(galvo.b_zero_urad * 1e-6);
  machine.galvo.a_scale = scalar(galvo.a_scale);
  machine.galvo.b_scale = scalar(galvo.b_scale);
  machine.galvo.direction_sigma_rad = scalar(galvo.direction_sigma_urad * 1e-6);
  for (int i = 0; i < 2; ++i) {
    const tg_CameraConfig& from = config.camera[i];
    CameraGeometry<Scalar>& camera = machine.camera[i];
    camera.detector = from.detector == tg_DetectorType_DETECTOR_TETRALATERAL ? Detector::kTetralateral
                                                                             : Detector::kDuolateral;
    camera.centre = vector_of<Scalar>(from.centre_mm);
    camera.x_axis = vector_of<Scalar>(from.x_axis);
    camera.y_axis = vector_of<Scalar>(from.y_axis);
    camera.focal_mm = scalar(from.focal_mm);
    camera.tilt_x_rad = scalar(from.tilt_x_rad);
    camera.tilt_y_rad = scalar(from.tilt_y_rad);
    camera.centre_x_mm = scalar(from.centre_x_mm);
    camera.centre_y_mm = scalar(from.centre_y_mm);
    camera.half_size_mm = scalar(from.half_size_mm);
    for (int k = 0; k < kDistortionTerms; ++k) {
      camera.distortion_x[k] = scalar(from.distortion_x[k]);
      camera.distortion_y[k] = scalar(from.distortion_y[k]);
    }
    camera.dark_variance_codes2 = scalar(from.dark_variance_codes2);
    camera.shot_variance_codes = scalar(from.shot_variance_codes);
    camera.position_sigma_mm = scalar(from.position_sigma_mm);
  }
  machine.stage.axis_point = vector_of<Scalar>(config.stage.axis_point_mm);
  machine.stage.axis_direction = vector_of<Scalar>(config.stage.axis_direction);
  machine.stage.slide_direction = vector_of<Scalar>(config.stage.slide_direction);
  machine.volume.min = vector_of<Scalar>(config.volume.min_mm);
  machine.volume.max = vector_of<Scalar>(config.volume.max_mm);
  return machine;
}

template MachineGeometry<float> geometry_of<float>(const MachineConfig&);
template MachineGeometry<double> geometry_of<double>(const MachineConfig&);

int64_t table_steps(const MachineConfig& config, int32_t table_udeg) {
  return rounded(table_udeg * (config.stage.table_steps_per_turn / kUdegPerTurn));
}
int64_t slide_steps(const MachineConfig& config, int32_t slide_um) {
  return rounded(slide_um * (config.stage.slide_steps_per_m / 1e6));
}
int32_t table_udeg(const MachineConfig& config, int64_t steps) {
  return saturated(static_cast<double>(steps) * (kUdegPerTurn / config.stage.table_steps_per_turn));
}
int32_t slide_um(const MachineConfig& config, int64_t steps) {
  return saturated(static_cast<double>(steps) * (1e6 / config.stage.slide_steps_per_m));
}

}  // namespace tetragauge
