// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/resting_positions.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "host/geometry/vec.hpp"

namespace tetragauge {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using HullMesh = CGAL::Surface_mesh<Kernel::Point_3>;

struct Hull {
  std::vector<Vec3> vertices;
  std::vector<double> sigma_mm;
  std::vector<std::array<uint32_t, 3>> facets;  // counter-clockwise from outside
};

bool before(const Vec3& a, const Vec3& b) {
  return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
}

Hull hull_of(const Reconstruction& reconstruction) {
  std::vector<uint8_t> used(reconstruction.vertices.size(), 0);
  for (const SurfaceTriangle& t : reconstruction.surface) {
    for (const uint32_t v : t.vertex) used[v] = 1;
  }
  std::vector<Kernel::Point_3> points;
  std::map<std::tuple<double, double, double>, double> sigma_at;
  for (size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    const Vec3& p = reconstruction.vertices[v];
    points.emplace_back(p.x(), p.y(), p.z());
  }
  Hull hull;
  HullMesh mesh;
  CGAL::convex_hull_3(points.begin(), points.end(), mesh);
  for (const auto v : mesh.vertices())
    sigma_at[{mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z()}] = 0;
  for (size_t v = 0; v < used.size(); ++v) {
    const Vec3& p = reconstruction.vertices[v];
    const auto found = sigma_at.find({p.x(), p.y(), p.z()});
    if (used[v] && found != sigma_at.end()) found->second = reconstruction.vertex_sigma_mm[v];
  }
  std::map<std::tuple<double, double, double>, uint32_t> number;
  for (const auto& [p, sigma] : sigma_at) {
    number[p] = static_cast<uint32_t>(hull.vertices.size());
    hull.vertices.emplace_back(std::get<0>(p), std::get<1>(p), std::get<2>(p));
    hull.sigma_mm.push_back(sigma);
  }
  for (const auto f : mesh.faces()) {
    std::array<uint32_t, 3> facet{};
    size_t k = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) {
      if (k < 3) facet[k++] = number[{mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z()}];
    }
    std::rotate(facet.begin(), std::min_element(facet.begin(), facet.end()), facet.end());
    hull.facets.push_back(facet);
  }
  std::sort(hull.facets.begin(), hull.facets.end());
  return hull;
}

// Convex, counter-clockwise about `normal` (Andrew's monotone chain), collinear points dropped.
std::vector<Vec3> convex_outline(std::vector<Vec3> points, const Vec3& normal) {
  const auto [u, v] = tangent_frame(normal);
  const auto flat = [&u = u, &v = v](const Vec3& p) { return Eigen::Vector2d(u.dot(p), v.dot(p)); };
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
    const auto p = flat(a), q = flat(b);
    return std::tuple(p.x(), p.y()) < std::tuple(q.x(), q.y());
  });
  const auto is_right_turn = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const Eigen::Vector2d p = flat(b) - flat(a), q = flat(c) - flat(a);
    return p.x() * q.y() - p.y() * q.x() <= 0;
  };
  std::vector<Vec3> outline;
  for (int pass = 0; pass < 2; ++pass) {
    const size_t start = outline.size();
    for (const Vec3& p : points) {
      while (outline.size() >= start + 2 && is_right_turn(outline[outline.size() - 2], outline.back(), p))
        outline.pop_back();
      outline.push_back(p);
    }
    outline.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return outline;
}

// Distance of p, seen along `normal`, to the nearest edge; negative outside.
double margin(const std::vector<Vec3>& outline, const Vec3& normal, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < outline.size(); ++i) {
    const Vec3& a = outline[i];
    const Vec3 edge = outline[(i + 1) % outline.size()] - a;
    nearest = std::min(nearest, normal.cross(edge).normalized().dot(p - a));
  }
  return nearest;
}

}  // namespace

std::vector<RestingPosition> resting_positions(const Reconstruction& reconstruction) {
  std::vector<RestingPosition> result;
  if (!(reconstruction.volume_mm3 > 0)) return result;
  const Hull hull = hull_of(reconstruction);
  const Vec3& centroid = reconstruction.centroid_mm;
  constexpr double kContactSigmas = 4;
  for (const auto& facet : hull.facets) {
    const Vec3 &a = hull.vertices[facet[0]], &b = hull.vertices[facet[1]], &c = hull.vertices[facet[2]];
    const Vec3 normal = (b - a).cross(c - a);
    if (!(normal.norm() > 0)) continue;
    const Vec3 down = normal.normalized();
    if (margin({a, b, c}, down, centroid) < 0) continue;
    RestingPosition position;
    position.down = down;
    position.d_mm = down.dot(a);
    position.height_mm = position.d_mm - down.dot(centroid);
    if (!(position.height_mm > 0)) continue;
    std::vector<Vec3> contact;
    for (size_t v = 0; v < hull.vertices.size(); ++v) {
      if (position.d_mm - down.dot(hull.vertices[v]) <= kContactSigmas * hull.sigma_mm[v])
        contact.push_back(hull.vertices[v]);
    }
    for (const uint32_t v : facet) contact.push_back(hull.vertices[v]);
    std::sort(contact.begin(), contact.end(), before);
    contact.erase(std::unique(contact.begin(), contact.end()), contact.end());
    position.contact_mm = convex_outline(std::move(contact), down);
    position.margin_mm = margin(position.contact_mm, down, centroid);
    position.tipping_rad = std::atan2(position.margin_mm, position.height_mm);
    result.push_back(std::move(position));
  }
  std::stable_sort(result.begin(), result.end(), [](const RestingPosition& p, const RestingPosition& q) {
    return p.tipping_rad > q.tipping_rad;
  });
  // Noise may give one face several facets with the centroid over them: the steadiest stands for all that it
  // touches.
  std::vector<RestingPosition> distinct;
  for (RestingPosition& p : result) {
    const bool is_known = std::any_of(distinct.begin(), distinct.end(), [&](const RestingPosition& q) {
      size_t shared = 0;
      for (const Vec3& c : p.contact_mm)
        shared += std::find(q.contact_mm.begin(), q.contact_mm.end(), c) != q.contact_mm.end() ? 1 : 0;
      return shared >= 3;
    });
    if (!is_known) distinct.push_back(std::move(p));
  }
  return distinct;
}

}  // namespace tetragauge
