// SPDX-License-Identifier: Apache-2.0
// The configuration as messages (what GetConfig and SetConfig carry), checked, and as geometry to compute
// with.
//
//   MachineConfig config = nominal_config();
//   MachineGeometry<double> geometry = geometry_of<double>(config);   // the host does the same with what it
//   was sent
#pragma once

#include "firmware/optics/geometry.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

struct MachineConfig {
  tg_GalvoConfig galvo = tg_GalvoConfig_init_zero;
  tg_CameraConfig camera[2] = {tg_CameraConfig_init_zero, tg_CameraConfig_init_zero};
  tg_StageConfig stage = tg_StageConfig_init_zero;
  tg_MeasureConfig measure = tg_MeasureConfig_init_zero;
  tg_VolumeConfig volume = tg_VolumeConfig_init_zero;
};

MachineConfig nominal_config();

// Null when the part is good, else what is wrong with it.
const char* config_error(const tg_Config& part);

// Puts the part (which has no config_error) in its place; reads it back.
void set_part(MachineConfig* config, const tg_Config& part);
bool get_part(const MachineConfig& config, tg_ConfigPart part, tg_Config* out);

// The whole of it as a calibration record carries it; its id and u_cal_100nm are the calibrator's.
tg_Calibration calibration_of(const MachineConfig& config);
// Null when every part is there and good, else what is wrong.
const char* calibration_error(const tg_Calibration& calibration);
void use_calibration(const tg_Calibration& calibration, MachineConfig* config);

// CRC-32C over the encoded parts in order of ConfigPart: the identity of a configuration.
uint32_t config_crc(const MachineConfig& config);

template <class Scalar>
MachineGeometry<Scalar> geometry_of(const MachineConfig& config);

// Whole steps and back; table in microdegrees, slide in micrometres, rounded to the nearest.
int64_t table_steps(const MachineConfig& config, int32_t table_udeg);
int64_t slide_steps(const MachineConfig& config, int32_t slide_um);
int32_t table_udeg(const MachineConfig& config, int64_t steps);
int32_t slide_um(const MachineConfig& config, int64_t steps);

}  // namespace tetragauge
