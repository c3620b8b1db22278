// SPDX-License-Identifier: GPL-3.0-or-later
// Parts for the tests of the planner, as they stand on the table.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "host/plan/plan_part.hpp"
#include "host/session/emulated_session.hpp"

namespace tetragauge::test {

// 60 x 50 x 40 mm with a slot 10 mm wide and 30 deep along x, open at both ends, and a blind hole 4 mm wide
// and 30 deep in its top whose bottom no beam can reach.
inline const char* const kSlotted =
    "difference() { cube(size = [60, 50, 40], center = false);\n"
    "multmatrix([[1, 0, 0, -1], [0, 1, 0, 12], [0, 0, 1, 10], [0, 0, 0, 1]]) { cube(size = [62, 10, 31], "
    "center = "
    "false); }\n"
    "multmatrix([[1, 0, 0, 30], [0, 1, 0, 36], [0, 0, 1, 10], [0, 0, 0, 1]]) { cube(size = [4, 4, 31], "
    "center = "
    "false); } }\n";

struct PlacedPart {
  std::filesystem::path file;
  Solid model;
  RayCaster caster;
  RigidTransform T_part_model;  // as the emulated machine stands it
};

inline PlacedPart placed(const std::string& csg) {
  const auto file = temporary_file("planned.csg", csg);
  Result<Solid> model = read_solid(file);
  EXPECT_TRUE(model) << model.error().message;
  const Vec3 middle = 0.5 * (model->box_min_mm + model->box_max_mm);
  const Vec3 shift(-middle.x(), -middle.y(), -model->box_min_mm.z());
  RayCaster caster(*model);
  return {file, std::move(*model), std::move(caster), {Mat3::Identity(), shift}};
}

// The plane face of the model with this normal at this offset.
inline int face_at(const Solid& model, const Vec3& normal, double d_mm) {
  for (const Face& face : model.faces())
    if (face.type == SurfaceType::plane && (face.normal - normal).norm() < 1e-9 &&
        std::abs(face.d_mm - d_mm) < 1e-6)
      return face.id;
  ADD_FAILURE() << "no face " << normal.transpose() << " at " << d_mm;
  return 1;
}

}  // namespace tetragauge::test
