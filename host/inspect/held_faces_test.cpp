// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/held_faces.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetragauge {
namespace {

Face face(SurfaceType type, const Vec3& direction, const Vec3& point) {
  Face out;
  out.type = type;
  out.normal = out.axis = direction.normalized();
  out.point_on_axis_mm = point;
  return out;
}

std::vector<SetUp> free_in(FreeDirection::Kind kind, const Vec3& axis, const Vec3& point) {
  std::vector<SetUp> set_ups(1);
  set_ups[0].match.max_offset_mm = 1;
  set_ups[0].match.undetermined = {{kind, axis.normalized(), point}};
  return set_ups;
}

// A turned part: body, shoulder, end, ball; then what is not turned with it.
Solid turned_part() {
  Solid part;
  const Vec3 z = Vec3::UnitZ();
  part.list.faces = {face(SurfaceType::cylinder, z, Vec3(0, 0, 5)),
                     face(SurfaceType::cone, -z, Vec3(0, 0, 9)),
                     face(SurfaceType::plane, z, Vec3::Zero()),
                     face(SurfaceType::sphere, z, Vec3(0, 0, 30)),
                     face(SurfaceType::torus, z, Vec3(0, 0, 12)),
                     face(SurfaceType::cylinder, Vec3::UnitX(), Vec3::Zero()),
                     face(SurfaceType::cylinder, z, Vec3(0.2, 0, 0)),
                     face(SurfaceType::sphere, z, Vec3(0.2, 0, 0)),
                     face(SurfaceType::plane, Vec3::UnitX(), Vec3(9, 0, 0)),
                     face(SurfaceType::other, z, Vec3::Zero())};
  return part;
}

std::vector<SetUp> set_ups_without_freedom() {
  return std::vector<SetUp>(2);
}

TEST(HeldFaces, ATurnedPartsFacesAreHeldWhateverItsTurn) {
  // The free axis as noisy points show it: a little off the part's own.
  const auto set_ups = free_in(FreeDirection::Kind::rotation, Vec3(0.002, -0.001, 1), Vec3(0.03, -0.02, 4));
  EXPECT_EQ(held_faces(turned_part(), set_ups),
            (std::vector<bool>{true, true, true, true, true, false, false, false, false, false}));
}

TEST(HeldFaces, AShiftAlongItsAxisMovesAConeAndNoCylinder) {
  const auto set_ups = free_in(FreeDirection::Kind::translation, Vec3::UnitZ(), Vec3::Zero());
  EXPECT_EQ(held_faces(turned_part(), set_ups),
            (std::vector<bool>{true, false, true, false, false, false, true, false, true, false}));
}

TEST(HeldFaces, AnAxisFarFromAllOfTheModelsIsItself) {
  const auto set_ups = free_in(FreeDirection::Kind::rotation, Vec3::UnitZ(), Vec3(40, 0, 0));
  const std::vector<bool> held = held_faces(turned_part(), set_ups);
  EXPECT_EQ(std::count(held.begin(), held.end(), true), 1);
  EXPECT_TRUE(held[2]);
}

TEST(HeldFaces, APoseWithoutFreeDirectionsHoldsAll) {
  const std::vector<bool> held = held_faces(turned_part(), set_ups_without_freedom());
  EXPECT_EQ(std::count(held.begin(), held.end(), true), 10);
}

}  // namespace
}  // namespace tetragauge
