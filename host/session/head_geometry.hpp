// SPDX-License-Identifier: GPL-3.0-or-later
// What the host needs of the machine's own configuration: where beams start, where they are aimed, how the
// table stands. Computed with the firmware's optics, so that both agree.
#pragma once

#include "firmware/optics/galvo.hpp"
#include "host/base/result.hpp"
#include "host/geometry/rigid_transform.hpp"
#include "host/session/plan.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

struct HeadGeometry {
  GalvoGeometry<double> galvo;
  StageGeometry<double> stage;
  // The aim plane of RasterWindow, machine frame.
  Vec3 aim_mm = Vec3::Zero();  // where the beam at rest comes nearest to the rotary axis
  Vec3 y = Vec3::Zero(), up = Vec3::Zero();
  int32_t mirror_limit_urad = 0;
};

// A ray in the machine frame.
struct MachineRay {
  Vec3 origin_mm = Vec3::Zero();
  Vec3 direction = Vec3::Zero();
};

HeadGeometry head_geometry(const tg_GalvoConfig& galvo, const tg_StageConfig& stage);

MachineRay ray_of_mirrors(const HeadGeometry& head, int32_t a_urad, int32_t b_urad);
RigidTransform T_machine_part(const HeadGeometry& head, double table_deg, double slide_mm);

// The view as the firmware measures it: equal mirror steps, about pitch_mm apart in the aim plane.
Result<tg_View> lay_raster(const HeadGeometry& head, const PlannedView& view);

}  // namespace tetragauge
