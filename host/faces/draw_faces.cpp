// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/draw_faces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/append_bytes.hpp"

namespace tetragauge {
namespace {

constexpr int kTile = 640;  // pixels
constexpr Colour kPaper{255, 255, 255}, kInk{20, 20, 20}, kNone{205, 205, 205}, kUnseen{110, 110, 110};

uint8_t byte(double x) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(x, 0.0, 1.0)));
}

// Hues a golden angle apart: neighbours in the list never look alike.
Colour colour_of_face(size_t k) {
  const double hue = 6 * std::fmod(0.07 + static_cast<double>(k) * 0.618034, 1.0);
  const double value = k % 3 == 1 ? 0.75 : 0.95, saturation = k % 2 ? 0.45 : 0.65;
  const auto channel = [&](double shift) {
    const double x = std::fmod(hue + shift, 6.0);
    return byte(value * (1 - saturation * std::clamp(std::min(x, 4 - x), 0.0, 1.0)));
  };
  return {channel(5), channel(3), channel(1)};
}

Colour shaded(Colour colour, double light) {
  for (uint8_t& c : colour) c = static_cast<uint8_t>(std::lround(c * light));
  return colour;
}

std::vector<int32_t> face_of_triangle(const Reconstruction& reconstruction, const MeasuredFaces& faces) {
  std::vector<int32_t> face(reconstruction.surface.size(), 0);
  for (size_t t = 0; t < face.size(); ++t) face[t] = reconstruction.surface[t].unseen ? -1 : 0;
  for (size_t k = 0; k < faces.face_triangles.size(); ++k) {
    for (uint32_t t : faces.face_triangles[k]) face[t] = static_cast<int32_t>(k) + 1;
  }
  return face;
}

Colour colour_of(int32_t face) {
  if (face > 0) return colour_of_face(static_cast<size_t>(face - 1));
  return face < 0 ? kUnseen : kNone;
}

// Parallel projection along `towards`, which points from the part to the eye.
struct Camera {
  Vec3 right, up, towards, middle;
  double scale = 1;

  Camera(const Vec3& from, const Vec3& centre, double radius_mm)
      : towards(from.normalized()), middle(centre), scale(0.46 * kTile / radius_mm) {
    const Vec3 helper = std::abs(towards.z()) > 0.9 ? Vec3::UnitY() : Vec3::UnitZ();
    right = helper.cross(towards).normalized();
    up = towards.cross(right);
  }
  Vec3 operator()(const Vec3& p) const {
    const Vec3 r = scale * (p - middle);
    return {0.5 * kTile + r.dot(right), 0.5 * kTile - r.dot(up), r.dot(towards)};
  }
};

Picture draw_view(const Reconstruction& reconstruction, const MeasuredFaces& faces,
                  const std::vector<int32_t>& face_of, const Camera& camera) {
  Picture picture(kTile, kTile, kPaper);
  for (size_t t = 0; t < face_of.size(); ++t) {
    const auto& v = reconstruction.surface[t].vertex;
    const Vec3 &a = reconstruction.vertices[v[0]], &b = reconstruction.vertices[v[1]],
               &c = reconstruction.vertices[v[2]];
    const double facing = (b - a).cross(c - a).normalized().dot(camera.towards);
    if (!(facing > 0)) continue;
    picture.fill_triangle(camera(a), camera(b), camera(c),
                          shaded(colour_of(face_of[t]), 0.55 + 0.45 * facing));
  }
  const double slack = 2 * camera.scale * reconstruction.vertex_spacing_mm;
  for (const auto& loops : faces.boundaries) {
    for (const BoundaryLoop& loop : loops) {
      for (size_t k = 0; k < loop.size(); ++k)
        picture.draw_line(camera(loop[k].from_mm), camera(loop[(k + 1) % loop.size()].from_mm), kInk, slack);
    }
  }
  for (const Face& face : faces.faces()) {
    const Vec3 p = camera(face.point_mm);
    if (face.normal.dot(camera.towards) > 0.1 && !picture.hides(p, slack))
      picture.draw_number(face.id, p.x(), p.y(), 3, kInk);
  }
  return picture;
}

}  // namespace

Picture draw_four_views(const Reconstruction& reconstruction, const MeasuredFaces& faces) {
  Picture sheet(2 * kTile, 2 * kTile, kPaper);
  if (reconstruction.vertices.empty()) return sheet;
  Vec3 low = reconstruction.vertices.front(), high = low;
  for (const Vec3& p : reconstruction.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const std::vector<int32_t> face_of = face_of_triangle(reconstruction, faces);
  const Vec3 from[4] = {{1, -1.3, 0.8}, {-1.3, 1, 0.8}, {1, 1.3, -0.8}, {-1, -1.3, -0.8}};
  for (int k = 0; k < 4; ++k) {
    const Camera camera(from[k], 0.5 * (low + high), std::max(1e-9, 0.5 * (high - low).norm()));
    sheet.put(draw_view(reconstruction, faces, face_of, camera), k % 2 * kTile, k / 2 * kTile);
  }
  return sheet;
}

Picture draw_gaussian_sphere(const MeasuredFaces& faces) {
  Picture sheet(2 * kTile, kTile, kPaper);
  double total = 0;
  for (const Face& face : faces.faces()) total += face.area_mm2;
  for (int side = 0; side < 2; ++side) {
    const Camera camera(side == 0 ? Vec3(1, -1.3, 0.8) : Vec3(-1, 1.3, -0.8), Vec3::Zero(), 1.2);
    Picture picture(kTile, kTile, kPaper);
    picture.fill_disc(Vec3(0.5 * kTile, 0.5 * kTile, -2 * kTile), camera.scale, Colour{238, 238, 238});
    // Parallels and meridians of the scan's frame, every 30 degrees.
    for (int line = 0; line < 6; ++line) {
      for (int step = 0; step < 180; ++step) {
        const auto on_sphere = [&](double longitude, double latitude) {
          return Vec3(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                      std::sin(latitude));
        };
        const double t0 = step * std::numbers::pi / 90, t1 = t0 + std::numbers::pi / 90,
                     fixed = line * std::numbers::pi / 6, latitude = (line - 2.5) * std::numbers::pi / 6;
        for (const auto& [a, b] : {std::pair(on_sphere(fixed, t0), on_sphere(fixed, t1)),
                                   std::pair(on_sphere(t0, latitude), on_sphere(t1, latitude))}) {
          if (a.dot(camera.towards) > 0 && b.dot(camera.towards) > 0)
            picture.draw_line(camera(a), camera(b), Colour{190, 190, 190}, 1e9);
        }
      }
    }
    for (size_t k = 0; k < faces.faces().size(); ++k) {
      const Face& face = faces.faces()[k];
      if (!(face.normal.dot(camera.towards) > 0)) continue;
      // The discs of all faces together have a third of the sphere's disc; large ones first, so that all
      // show.
      const double radius = camera.scale * std::sqrt(face.area_mm2 / (3 * total));
      Vec3 p = camera(face.normal);
      p.z() = static_cast<double>(k);
      picture.fill_disc(p, radius + 1, kInk);
      picture.fill_disc(p, radius, colour_of_face(k));
      picture.draw_number(face.id, p.x(), p.y(), 2, kInk);
    }
    sheet.put(picture, side * kTile, 0);
  }
  return sheet;
}

std::string coloured_surface_ply(const Reconstruction& reconstruction, const MeasuredFaces& faces) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\ncomment frame part\ncomment unit mm\nelement vertex " +
      std::to_string(reconstruction.vertices.size()) +
      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
      std::to_string(reconstruction.surface.size()) +
      "\nproperty list uchar uint vertex_indices\nproperty uchar red\nproperty uchar green\nproperty "
      "uchar blue\nproperty int face\nend_header\n";
  for (const Vec3& p : reconstruction.vertices) {
    for (int k = 0; k < 3; ++k) append_bytes(out, p[k]);
  }
  const std::vector<int32_t> face_of = face_of_triangle(reconstruction, faces);
  for (size_t t = 0; t < face_of.size(); ++t) {
    append_bytes(out, uint8_t{3});
    for (uint32_t v : reconstruction.surface[t].vertex) append_bytes(out, v);
    for (const uint8_t c : colour_of(face_of[t])) append_bytes(out, c);
    append_bytes(out, face_of[t]);
  }
  return out;
}

}  // namespace tetragauge
