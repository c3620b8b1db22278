// SPDX-License-Identifier: GPL-3.0-or-later
// A picture in memory, what is drawn into it, and PNG.
#pragma once

#include <string>
#include <vector>

#include "host/base/encode_png.hpp"
#include "host/geometry/vec.hpp"

namespace tetragauge {

// Rows from the top; depth: larger is nearer.
class Picture {
 public:
  Picture(int width, int height, Colour background);

  int width() const { return width_; }
  int height() const { return height_; }

  // Corners in pixels (x to the right, y down) and depth.
  void fill_triangle(const Vec3& a, const Vec3& b, const Vec3& c, Colour colour);
  void fill_disc(const Vec3& centre, double radius, Colour colour);
  // Where nothing lies nearer than `slack` before it.
  void draw_line(const Vec3& a, const Vec3& b, Colour colour, double slack);
  // Digits, 3 x 5 dots each, centred.
  void draw_number(int number, double x, double y, int dot, Colour colour);
  bool hides(const Vec3& p, double slack) const;
  void put(const Picture& part, int left, int top);

  std::string png() const;

 private:
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  size_t at(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }

  int width_, height_;
  std::vector<Colour> colour_;
  std::vector<double> depth_;
};

}  // namespace tetragauge
