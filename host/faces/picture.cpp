// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetragauge {

Picture::Picture(int width, int height, Colour background)
    : width_(width),
      height_(height),
      colour_(static_cast<size_t>(width) * static_cast<size_t>(height), background),
      depth_(colour_.size(), -std::numeric_limits<double>::infinity()) {}

void Picture::fill_triangle(const Vec3& a, const Vec3& b, const Vec3& c, Colour colour) {
  const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
  if (area == 0 || !std::isfinite(area)) return;
  const int x0 = std::max(0, static_cast<int>(std::floor(std::min({a.x(), b.x(), c.x()})))),
            x1 = std::min(width_ - 1, static_cast<int>(std::ceil(std::max({a.x(), b.x(), c.x()})))),
            y0 = std::max(0, static_cast<int>(std::floor(std::min({a.y(), b.y(), c.y()})))),
            y1 = std::min(height_ - 1, static_cast<int>(std::ceil(std::max({a.y(), b.y(), c.y()}))));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double u = ((x - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (y - a.y())) / area;
      const double v = ((b.x() - a.x()) * (y - a.y()) - (x - a.x()) * (b.y() - a.y())) / area;
      if (u < 0 || v < 0 || u + v > 1) continue;
      const double depth = a.z() + u * (b.z() - a.z()) + v * (c.z() - a.z());
      if (depth <= depth_[at(x, y)]) continue;
      depth_[at(x, y)] = depth;
      colour_[at(x, y)] = colour;
    }
  }
}

void Picture::fill_disc(const Vec3& centre, double radius, Colour colour) {
  for (int y = static_cast<int>(centre.y() - radius); y <= centre.y() + radius; ++y) {
    for (int x = static_cast<int>(centre.x() - radius); x <= centre.x() + radius; ++x) {
      if (!contains(x, y) || std::hypot(x - centre.x(), y - centre.y()) > radius) continue;
      if (centre.z() < depth_[at(x, y)]) continue;
      depth_[at(x, y)] = centre.z();
      colour_[at(x, y)] = colour;
    }
  }
}

void Picture::draw_line(const Vec3& a, const Vec3& b, Colour colour, double slack) {
  const int steps =
      std::min(10000, 1 + static_cast<int>(std::ceil(std::hypot(b.x() - a.x(), b.y() - a.y()))));
  for (int k = 0; k <= steps; ++k) {
    const Vec3 p = a + (b - a) * (static_cast<double>(k) / steps);
    const int x = static_cast<int>(std::lround(p.x())), y = static_cast<int>(std::lround(p.y()));
    if (contains(x, y) && depth_[at(x, y)] <= p.z() + slack) colour_[at(x, y)] = colour;
  }
}

bool Picture::hides(const Vec3& p, double slack) const {
  const int x = static_cast<int>(std::lround(p.x())), y = static_cast<int>(std::lround(p.y()));
  return !contains(x, y) || depth_[at(x, y)] > p.z() + slack;
}

void Picture::draw_number(int number, double x, double y, int dot, Colour colour) {
  static constexpr std::array<const char*, 10> kDigits = {
      "#### ## ## ####", " # ##  #  # ###", "###  #####  ###", "###  ####  ####", "# ## ####  #  #",
      "####  ###  ####", "####  #### ####", "###  #  #  #  #", "#### ##### ####", "#### ####  ####"};
  const std::string digits = std::to_string(number);
  const int left = static_cast<int>(std::lround(x)) - static_cast<int>(digits.size()) * 2 * dot;
  const int top = static_cast<int>(std::lround(y)) - 5 * dot / 2;
  for (size_t k = 0; k < digits.size(); ++k) {
    if (digits[k] < '0' || digits[k] > '9') continue;
    const char* const shape = kDigits[static_cast<size_t>(digits[k] - '0')];
    for (int i = 0; i < 15 * dot * dot; ++i) {
      const int column = i % (3 * dot), row = i / (3 * dot);
      const int px = left + static_cast<int>(k) * 4 * dot + column, py = top + row;
      if (shape[row / dot * 3 + column / dot] == '#' && contains(px, py)) colour_[at(px, py)] = colour;
    }
  }
}

void Picture::put(const Picture& part, int left, int top) {
  for (int y = 0; y < part.height_; ++y) {
    for (int x = 0; x < part.width_; ++x) {
      if (contains(left + x, top + y)) colour_[at(left + x, top + y)] = part.colour_[part.at(x, y)];
    }
  }
}

std::string Picture::png() const {
  return encode_png(colour_, static_cast<size_t>(width_));
}

}  // namespace tetragauge
