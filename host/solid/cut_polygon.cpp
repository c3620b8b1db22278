// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/cut_polygon.hpp"

namespace tetragauge {
namespace {

// Ear clipping takes the square of this many steps, at worst the cube.
constexpr size_t kMostCorners = 1000;

// Newell: twice the vector area.
Vec3 double_area(const TriangleMesh& mesh, const std::vector<uint32_t>& loop) {
  Vec3 sum = Vec3::Zero();
  const Vec3& origin = mesh.vertices[loop[0]];
  for (size_t i = 0; i < loop.size(); ++i) {
    sum += (mesh.vertices[loop[i]] - origin).cross(mesh.vertices[loop[(i + 1) % loop.size()]] - origin);
  }
  return sum;
}

// Whether the corner at `i` can be cut off: it turns left, and no other corner lies in its triangle.
bool is_ear(const TriangleMesh& mesh, const std::vector<uint32_t>& loop, size_t i, const Vec3& normal) {
  const size_t n = loop.size();
  const uint32_t ia = loop[(i + n - 1) % n], ib = loop[i], ic = loop[(i + 1) % n];
  const Vec3 &a = mesh.vertices[ia], &b = mesh.vertices[ib], &c = mesh.vertices[ic];
  const auto turn = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    return normal.dot((q - p).cross(r - p));
  };
  if (!(turn(a, b, c) > 0)) return false;
  for (const uint32_t other : loop) {
    if (other == ia || other == ib || other == ic) continue;
    const Vec3& p = mesh.vertices[other];
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

// Meisters, "Polygons have ears", Am. Math. Monthly 82 (1975) 648.
Status add_polygon(const std::vector<int64_t>& corners, const std::string& place, TriangleMesh& mesh) {
  if (corners.size() < 3) return bad_input(place + "a face needs three corners");
  if (corners.size() > kMostCorners) {
    return bad_input(place + "a face of " + std::to_string(corners.size()) +
                     " corners; split it into triangles");
  }
  std::vector<uint32_t> loop;
  for (const int64_t corner : corners) {
    if (corner < 0 || corner >= static_cast<int64_t>(mesh.vertices.size())) {
      return bad_input(place + "a face names vertex " + std::to_string(corner) + " (counted from 0) of " +
                       std::to_string(mesh.vertices.size()) + "; export it again");
    }
    loop.push_back(static_cast<uint32_t>(corner));
  }
  if (loop.size() > 3) {
    const Vec3 normal = double_area(mesh, loop);
    size_t i = 0, passed = 0;
    while (loop.size() > 3 && passed < loop.size()) {
      i %= loop.size();
      if (!is_ear(mesh, loop, i, normal)) {
        ++i;
        ++passed;
        continue;
      }
      const size_t n = loop.size();
      mesh.triangles.push_back({loop[(i + n - 1) % n], loop[i], loop[(i + 1) % n]});
      loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(i));
      passed = 0;
    }
  }
  // What has no ear left has no area that could be cut better than by a fan.
  for (size_t k = 1; k + 1 < loop.size(); ++k) mesh.triangles.push_back({loop[0], loop[k], loop[k + 1]});
  return Done{};
}

}  // namespace tetragauge
