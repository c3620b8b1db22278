// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/bench_parts.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>
#include <utility>

namespace tetragauge::bench {
namespace {

using Polygon = std::vector<std::pair<double, double>>;

// Sizes: the nominal one, or one drawn between limits.
class Sizes {
 public:
  explicit Sizes(uint64_t seed) : fixed_(seed == 0), random_(seed) {}
  double operator()(double nominal, double low, double high) {
    const double share = static_cast<double>(random_() >> 11) * 0x1.0p-53;
    return fixed_ ? nominal : low + share * (high - low);
  }

 private:
  bool fixed_;
  std::mt19937_64 random_;
};

std::string number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::string moved(const std::string& solid, double x, double y, double z) {
  return "multmatrix([[1, 0, 0, " + number(x) + "], [0, 1, 0, " + number(y) + "], [0, 0, 1, " + number(z) +
         "], [0, 0, 0, 1]]) {" + solid + "}\n";
}

std::string box(double x, double y, double z) {
  return "cube(size = [" + number(x) + ", " + number(y) + ", " + number(z) + "], center = false);\n";
}

std::string box_at(double x0, double y0, double z0, double x, double y, double z) {
  return moved(box(x, y, z), x0, y0, z0);
}

std::string prism(const Polygon& polygon, double height) {
  std::string points;
  for (const auto& [x, y] : polygon)
    points += (points.empty() ? "[" : ", [") + number(x) + ", " + number(y) + "]";
  return "linear_extrude(height = " + number(height) +
         ", center = false, convexity = 1, scale = [1, 1]) { polygon(points = [" + points +
         "], paths = undef, convexity = 1); }\n";
}

std::string difference(const std::string& parts) {
  return "difference() {\n" + parts + "}\n";
}
std::string together(const std::string& parts) {
  return "union() {\n" + parts + "}\n";
}

Polygon regular_polygon(int sides, double radius) {
  Polygon p;
  for (int i = 0; i < sides; ++i) {
    const double a = 2 * std::numbers::pi * i / sides;
    p.emplace_back(radius * std::cos(a), radius * std::sin(a));
  }
  return p;
}

struct Kind {
  const char* name;
  std::string (*make)(Sizes&);
};

const Kind kKinds[] = {
    {"box", [](Sizes& s) { return box(s(80, 40, 95), s(60, 30, 80), s(40, 20, 60)); }},
    {"wedge",
     [](Sizes& s) {
       const double w = s(80, 50, 95);
       return prism({{0, 0}, {w, 0}, {w, s(10, 5, 20)}, {0, s(56, 30, 60)}}, s(50, 25, 70));
     }},
    {"polygon",  // 18 sides
     [](Sizes& s) { return prism(regular_polygon(18, s(40, 32, 48)), s(40, 25, 70)); }},
    {"tetrahedron",
     [](Sizes& s) {
       const double a = s(80, 50, 90), b = s(70, 40, 80), c = s(60, 35, 70);
       return "polyhedron(points = [[0, 0, 0], [" + number(a) + ", 0, 0], [" + number(0.3 * a) + ", " +
              number(b) + ", 0], [" + number(0.4 * a) + ", " + number(0.3 * b) + ", " + number(c) +
              "]], faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], convexity = 1);\n";
     }},
    {"bracket",
     [](Sizes& s) {
       const double w = s(80, 50, 95), h = s(50, 30, 70), t = s(12, 6, 15);
       return prism({{0, 0}, {w, 0}, {w, t}, {t, t}, {t, h}, {0, h}}, s(60, 30, 70));
     }},
    {"channel",  // a slot along all of it
     [](Sizes& s) {
       const double w = s(60, 45, 80), h = s(40, 30, 50), a = s(20, 12, 20), b = s(40, 28, 42),
                    f = s(20, 12, 25);
       return prism({{0, 0}, {w, 0}, {w, h}, {b, h}, {b, f}, {a, f}, {a, h}, {0, h}}, s(95, 60, 100));
     }},
    {"t-slot",  // undercut
     [](Sizes& s) {
       const double w = s(60, 55, 75), h = s(40, 34, 50), m = w / 2, n = s(5, 4.5, 7), c = s(12, 10, 15);
       const double f = s(15, 10, 16), g = f + s(10, 7, 11);
       return prism({{0, 0},
                     {w, 0},
                     {w, h},
                     {m + n, h},
                     {m + n, g},
                     {m + c, g},
                     {m + c, f},
                     {m - c, f},
                     {m - c, g},
                     {m - n, g},
                     {m - n, h},
                     {0, h}},
                    s(80, 50, 90));
     }},
    {"dovetail",  // undercut
     [](Sizes& s) {
       const double w = s(80, 70, 95), h = s(40, 32, 48), m = w / 2, n = s(10, 9, 13), c = s(18, 16, 22);
       const double f = s(20, 14, 22);
       return prism({{0, 0}, {w, 0}, {w, h}, {m + n, h}, {m + c, f}, {m - c, f}, {m - n, h}, {0, h}},
                    s(60, 40, 80));
     }},
    {"terraces",
     [](Sizes& s) {
       const double w = s(80, 60, 90), r = s(10, 6, 12), h = s(15, 8, 18);
       return together(box(w, w, h) + box_at(r, r, 0, w - 2 * r, w - 2 * r, 2 * h) +
                       box_at(2 * r, 2 * r, 0, w - 4 * r, w - 4 * r, 3 * h));
     }},
    {"pockets",
     [](Sizes& s) {
       const double h = s(30, 25, 40), d = s(20, 10, 20), e = s(12, 8, 14);
       return difference(box(90, 70, h) + box_at(10, 15, h - d, s(40, 30, 42), 40, 50) +
                         box_at(62, 10, h - e, s(18, 14, 20), s(45, 30, 48), 50));
     }},
    {"step of 1 mm",  // parallel planes 1 mm apart
     [](Sizes& s) {
       const double w = s(80, 50, 90), h = s(20, 12, 30), a = s(40, 20, 35);
       return prism({{0, 0}, {w, 0}, {w, h}, {a, h}, {a, h + 1}, {0, h + 1}}, s(60, 40, 70));
     }},
    {"tray, 2 mm walls",
     [](Sizes& s) {
       const double x = s(70, 50, 85), y = s(55, 40, 65), z = s(25, 15, 30);
       return difference(box(x, y, z) + box_at(2, 2, 2, x - 4, y - 4, z));
     }},
    {"rib, 2 mm wall",
     [](Sizes& s) {
       const double w = s(60, 40, 80), t = s(6, 5, 12), h = s(35, 20, 40), a = s(28, 10, 30);
       return prism({{0, 0}, {w, 0}, {w, t}, {a + 2, t}, {a + 2, h}, {a, h}, {a, t}, {0, t}}, s(50, 30, 60));
     }},
    {"chamfers of 3 mm",
     [](Sizes& s) {
       const double w = s(80, 50, 90), h = s(40, 25, 50);
       return prism({{0, 0}, {w, 0}, {w, h - 3}, {w - 3, h}, {3, h}, {0, h - 3}}, s(60, 30, 70));
     }},
    {"chamfers of 1 mm",
     [](Sizes& s) {
       const double w = s(50, 40, 60), h = s(30, 20, 40);
       return prism({{0, 0}, {w, 0}, {w, h - 1}, {w - 1, h}, {1, h}, {0, h - 1}}, s(40, 25, 50));
     }},
    {"draft of 1 degree",
     [](Sizes& s) {
       const double w = s(80, 50, 90), h = s(40, 30, 60), d = h * std::tan(std::numbers::pi / 180);
       return prism({{0, 0}, {w, 0}, {w - d, h}, {d, h}}, s(60, 40, 70));
     }},
    {"roof of 1 degree",  // two planes that meet at 1 degree
     [](Sizes& s) {
       const double w = s(80, 60, 90), a = s(40, 25, 45), h = s(30, 15, 40);
       return prism({{0, 0}, {w, 0}, {w, h}, {a, h}, {0, h - a * std::tan(std::numbers::pi / 180)}},
                    s(60, 40, 70));
     }},
    {"staircase of the thesis",
     [](Sizes& s) {
       const double k = s(1, 0.7, 1.2);
       Polygon p;
       for (const auto& [x, z] : Polygon{{0, 0},
                                         {80, 0},
                                         {80, 20},
                                         {60, 20},
                                         {60, 40},
                                         {40, 40},
                                         {40, 50},
                                         {20, 50},
                                         {20, 60},
                                         {0, 60},
                                         {0, 40},
                                         {30, 10},
                                         {0, 10}})
         p.emplace_back(k * x, k * z);
       return prism(p, k * 60);
     }},
    {"61 faces",  // eleven bosses on a plate
     [](Sizes& s) {
       const double h = s(12, 8, 16), b = s(12, 9, 13), t = s(10, 5, 12);
       std::string parts = box(96, 76, h);
       int bosses = 0;
       for (int i = 0; i < 4; ++i) {
         for (int j = 0; j < 3 && bosses < 11; ++j, ++bosses)
           parts += box_at(6 + 24 * i, 6 + 24 * j, h, b, b + 0.5 * i, t + 0.7 * j);
       }
       return together(parts);
     }},
    {"comb",  // deep slots between teeth
     [](Sizes& s) {
       const double h = s(30, 24, 36), f = s(16, 10, 20), tooth = s(6, 5, 8), gap = s(9, 7, 10);
       Polygon p{{0, 0}, {6 * tooth + 5 * gap, 0}};
       for (int i = 5; i >= 0; --i) {
         const double x = i * (tooth + gap);
         p.emplace_back(x + tooth, h);
         p.emplace_back(x, h);
         if (i > 0) {
           p.emplace_back(x, f);
           p.emplace_back(x - gap, f);
         }
       }
       return prism(p, s(50, 30, 60));
     }},
};

}  // namespace

std::vector<std::string> bench_part_names() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

BenchPart bench_part(const std::string& name, uint64_t seed) {
  Sizes sizes(seed);
  for (const Kind& kind : kKinds) {
    if (name == kind.name) return {name, kind.make(sizes)};
  }
  return {name, ""};
}

}  // namespace tetragauge::bench
