// SPDX-License-Identifier: GPL-3.0-or-later
// Solids of the tests, from .csg text through a file as a user would give it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "host/solid/solid.hpp"

namespace tetragauge::test {

// The thesis's staircase (Cakir 1989), mm.
inline constexpr const char* kStaircase =
    "multmatrix([[1, 0, 0, 0], [0, 0, -1, 60], [0, 1, 0, 0], [0, 0, 0, 1]]) {\n"
    "  linear_extrude(height = 60, center = false, convexity = 1, scale = [1, 1]) {\n"
    "    polygon(points = [[0, 0], [80, 0], [80, 20], [60, 20], [60, 40], [40, 40], [40, 50], [20, 50], [20, "
    "60],\n"
    "      [0, 60], [0, 40], [30, 10], [0, 10]], paths = undef, convexity = 1); } }\n";

inline Result<Solid> read_text(const std::string& text, const std::string& ending,
                               const ReadSolidOptions& options = {}) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) /
      (std::string("tetragauge_") + info->test_suite_name() + "_" + info->name() + ending);
  std::ofstream(path, std::ios::binary) << text;
  Result<Solid> solid = read_solid(path, options);
  std::filesystem::remove(path);
  return solid;
}

inline Solid solid_from_csg(const std::string& text, const ReadSolidOptions& options = {}) {
  Result<Solid> solid = read_text(text, ".csg", options);
  if (!solid) {
    ADD_FAILURE() << solid.error().message;
    return {};
  }
  return std::move(solid).value();
}

inline std::string error_of(const std::string& text, const std::string& ending = ".csg") {
  const Result<Solid> solid = read_text(text, ending);
  if (solid) return "";
  EXPECT_EQ(solid.error().kind, ErrorKind::bad_input);
  return solid.error().message;
}

inline int count(const Solid& solid, SurfaceType type) {
  return static_cast<int>(std::count_if(solid.faces().begin(), solid.faces().end(),
                                        [&](const Face& face) { return face.type == type; }));
}

}  // namespace tetragauge::test
