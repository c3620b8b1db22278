// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/machine_parts.hpp"

#include <cstdio>
#include <functional>
#include <utility>

namespace tetragauge::bench {
namespace {

using Polygon = std::vector<std::pair<double, double>>;

std::string number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::string moved(const std::string& solid, double x, double y, double z) {
  return "multmatrix([[1, 0, 0, " + number(x) + "], [0, 1, 0, " + number(y) + "], [0, 0, 1, " + number(z) +
         "], [0, 0, 0, 1]]) {" + solid + "}\n";
}

std::string box(double x0, double y0, double z0, double x1, double y1, double z1) {
  return moved("cube(size = [" + number(x1 - x0) + ", " + number(y1 - y0) + ", " + number(z1 - z0) +
                   "], center = false);",
               x0, y0, z0);
}

std::string cylinder(double x, double y, double z0, double z1, double r) {
  return moved("cylinder($fn = 0, h = " + number(z1 - z0) + ", r1 = " + number(r) + ", r2 = " + number(r) +
                   ", center = false);",
               x, y, z0);
}

// Swept along z.
std::string prism(const Polygon& polygon, double height) {
  std::string points;
  for (const auto& [x, y] : polygon)
    points += (points.empty() ? "[" : ", [") + number(x) + ", " + number(y) + "]";
  return "linear_extrude(height = " + number(height) +
         ", center = false, convexity = 1, scale = [1, 1]) { polygon(points = [" + points +
         "], paths = undef, convexity = 1); }\n";
}

std::string difference(const std::string& children) {
  return "difference() {\n" + children + "}\n";
}
std::string together(const std::string& children) {
  return "union() {\n" + children + "}\n";
}

// `make(x)` with the length that is right, and with the one that is wrong.
MachinePart part(const std::string& name, const std::function<std::string(double)>& make, double right,
                 double wrong, const std::vector<double>& normal, double d, bool has_slots,
                 const std::string& place = "") {
  return {name, make(right), make(wrong), place, {normal[0], normal[1], normal[2]}, d, has_slots};
}

}  // namespace

const std::vector<MachinePart>& machine_parts() {
  static const std::vector<MachinePart> parts{
      // The thesis's, on an end.
      part(
          "staircase",
          [](double x) {
            return prism({{0, 0},
                          {80, 0},
                          {80, 20},
                          {x, 20},
                          {x, 40},
                          {40, 40},
                          {40, 50},
                          {20, 50},
                          {20, 60},
                          {0, 60},
                          {0, 40},
                          {30, 10},
                          {0, 10}},
                         60);
          },
          60, 60.4, {1, 0, 0}, 60, false),
      part(
          "bracket",
          [](double y) {
            return moved(prism({{0, 0}, {80, 0}, {80, y}, {16, y}, {16, 52}, {0, 52}}, 46), 0, 0, 0);
          },
          14, 14.4, {0, 1, 0}, 14, false),
      part(
          "wedge",
          [](double x) {
            return prism({{0, 0}, {x, 0}, {x, 12}, {40, 30}, {0, 40}}, 60);
          },
          72, 72.4, {1, 0, 0}, 72, false),
      part(
          "plate with holes",
          [](double y) {
            return difference(box(0, 0, 0, 90, y, 12) + cylinder(20, 20, -1, 13, 10) +
                              cylinder(62, 34, -1, 13, 14) + cylinder(30, 44, 6, 13, 6));
          },
          60, 60.4, {0, 1, 0}, 60, false),
      part(
          "shaft with a flat",
          [](double x) {
            return difference(together(cylinder(0, 0, 0, 30, 30) + cylinder(0, 0, 30, 80, 18)) +
                              box(x, -40, 40, 40, 40, 90) + box(-40, 20, -1, 40, 40, 20));
          },
          12, 12.4, {1, 0, 0}, 12, false),
      part(
          "U-channel",
          [](double x) {
            return difference(box(0, 0, 0, 70, 60, 46) + box(22, -1, 14, x, 61, 47) +
                              box(-1, 40, 30, 23, 61, 47));
          },
          50, 50.4, {-1, 0, 0}, -50, true),
      part(
          "block with a narrow slot",
          [](double z) {
            return difference(box(0, 0, 0, 64, 70, z) + box(28, -1, 8, 36, 71, 45) +
                              box(-1, 50, 24, 20, 71, 45));
          },
          40, 40.4, {0, 0, 1}, 40, true),
      part(
          "T-slot",
          [](double x) {
            return prism({{0, 0},
                          {x, 0},
                          {x, 44},
                          {48, 44},
                          {48, 30},
                          {62, 30},
                          {62, 14},
                          {18, 14},
                          {18, 30},
                          {32, 30},
                          {32, 44},
                          {0, 50}},
                         50);
          },
          80, 80.4, {1, 0, 0}, 80, true),
      part(
          "pocket and notch",
          [](double x) {
            return difference(box(0, 0, 0, 76, 60, 36) + box(18, 14, 20, x, 44, 37) +
                              box(62, -1, 12, 77, 18, 37));
          },
          52, 52.4, {-1, 0, 0}, -52, true),
      part(
          "comb",
          [](double x) {
            return difference(box(0, 0, 0, x, 50, 40) + box(12, -1, 16, 22, 51, 41) +
                              box(34, -1, 22, 44, 51, 41) + box(56, -1, 10, 64, 51, 41));
          },
          80, 80.4, {1, 0, 0}, 80, true),
      part(
          "dovetail",
          [](double x) {
            return prism({{0, 0}, {x, 0}, {x, 40}, {62, 40}, {70, 18}, {30, 18}, {38, 40}, {0, 40}}, 56);
          },
          90, 90.4, {1, 0, 0}, 90, true),
      part(
          "mushroom",
          [](double z) {
            return together(box(20, 20, 0, 50, 44, 50) + box(0, 0, 40, 74, 66, z) + box(0, 0, 0, 60, 50, 10));
          },
          56, 56.4, {0, 0, 1}, 56, true),
  };
  return parts;
}

}  // namespace tetragauge::bench
