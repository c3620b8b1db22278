// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/measure_cell.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numbers>
#include <random>

#include "host/base/whole_file.hpp"
#include "host/scan/scan_file.hpp"
#include "host/simulate/simulate.hpp"
#include "host/solid/ray_caster.hpp"
#include "tests/bench/measure_shadow.hpp"

namespace tetragauge::bench {
namespace {

struct Segment {
  Vec3 a, b;
  double length() const { return (b - a).norm(); }
  double distance(const Vec3& p) const {
    const Vec3 e = b - a;
    const double t = std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0);
    return (p - a - t * e).norm();
  }
};

struct TrueFace {
  std::vector<Segment> rim;
  double perimeter_mm = 0;
  double width_mm = 0;         // of the widest circle about a point of the scan that stays within the rim
  size_t points = 0;           // that were measured on it
  Vec3 middle = Vec3::Zero();  // of these points, model frame: there the offset's error is sigma / sqrt(n)
};

using Micrometres = std::array<int64_t, 3>;
Micrometres rounded(const Vec3& p) {
  return {std::llround(p.x() * 1e3), std::llround(p.y() * 1e3), std::llround(p.z() * 1e3)};
}

// The rim of each face: edges that only one of its triangles has.
std::vector<TrueFace> true_faces(const Solid& solid) {
  std::vector<std::map<std::pair<Micrometres, Micrometres>, std::pair<int, Segment>>> edges(
      solid.faces().size());
  for (size_t t = 0; t < solid.triangles.size(); ++t) {
    for (size_t i = 0; i < 3; ++i) {
      const Vec3 &a = solid.vertices[solid.triangles[t][i]],
                 &b = solid.vertices[solid.triangles[t][(i + 1) % 3]];
      auto& edge = edges[solid.triangle_face[t]][std::minmax(rounded(a), rounded(b))];
      ++edge.first;
      edge.second = {a, b};
    }
  }
  std::vector<TrueFace> faces(solid.faces().size());
  for (size_t f = 0; f < faces.size(); ++f) {
    for (const auto& [key, edge] : edges[f]) {
      if (edge.first != 1) continue;
      faces[f].rim.push_back(edge.second);
      faces[f].perimeter_mm += edge.second.length();
    }
  }
  return faces;
}

RigidTransform random_pose(uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  };
  const double x = uniform(-180, 180), y = uniform(-90, 90), z = uniform(-180, 180);
  return {rotation_from_degrees(x, y, z), Vec3(uniform(-50, 50), uniform(-50, 50), uniform(-50, 50))};
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string text(const char* format, auto... values) {
  char line[300];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

class Comparison {
 public:
  Comparison(const Solid& solid, const CellOptions& options, Cell& cell)
      : solid_(solid),
        options_(options),
        cell_(cell),
        T_(random_pose(options.seed * 7919 + 17)),
        caster_(solid),
        truth_(true_faces(solid)) {}

  Status run() {
    SimulateOptions how;
    how.points = options_.points;
    how.sigma_mm = options_.sigma_mm;
    how.seed = options_.seed;
    how.T_scan_model = T_;
    Result<Scan> scan = simulate(solid_, caster_, how);
    if (!scan) return scan.error();
    cell_.points = scan->size();
    cell_.spacing_mm = std::sqrt(solid_.area_mm2 / static_cast<double>(scan->size()));
    hit_faces(*scan);

    auto start = std::chrono::steady_clock::now();
    Result<Reconstruction> reconstruction = reconstruct(*scan);
    if (!reconstruction) return reconstruction.error();
    cell_.reconstruct_s = seconds_since(start);
    start = std::chrono::steady_clock::now();
    Result<MeasuredFaces> faces = find_faces(*scan, *reconstruction, options_.faces);
    if (!faces) return faces.error();
    cell_.faces_s = seconds_since(start);
    cell_.rays_lost = reconstruction->rays_lost;
    compare_faces(*faces);
    compare_volumes(*reconstruction, *faces);
    if (!cell_.passes()) explain(*scan, how.max_incidence_rad);
    if (!options_.save_to.empty() && !cell_.passes()) return save(*scan);
    return Done{};
  }

 private:
  // The true face under each point: noise along the ray does not change where the ray hits.
  void hit_faces(const Scan& scan) {
    const RigidTransform T_model_scan = T_.inverse();
    hit_face_.assign(scan.size(), -1);
    for (size_t i = 0; i < scan.size(); ++i) {
      const auto hit =
          caster_.first_hit(T_model_scan * scan.ray_origins[i], T_model_scan.R * scan.ray_direction(i));
      if (!hit) continue;
      hit_face_[i] = hit->face;
      TrueFace& face = truth_[static_cast<size_t>(hit->face)];
      ++face.points;
      face.middle += hit->point_mm;
      double clear = 1e9;
      for (const Segment& s : face.rim) clear = std::min(clear, s.distance(hit->point_mm));
      face.width_mm = std::max(face.width_mm, 2 * clear);
    }
    for (TrueFace& face : truth_) face.middle /= std::max(1.0, static_cast<double>(face.points));
  }

  bool is_wanted(const TrueFace& face) const {
    return face.points >= 30 && face.width_mm >= 2 * cell_.spacing_mm;
  }

  void compare_faces(const MeasuredFaces& measured) {
    std::vector<size_t> times(truth_.size(), 0);
    for (size_t k = 0; k < measured.faces().size(); ++k) {
      std::map<int, size_t> votes;
      for (uint32_t i : measured.face_points[k]) ++votes[hit_face_[i]];
      const auto best = std::max_element(votes.begin(), votes.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      const Face& face = measured.faces()[k];
      const bool mixed = best == votes.end() || best->first < 0 || 10 * best->second < 7 * face.points;
      if (mixed || times[static_cast<size_t>(best->first)] > 0) {
        ++cell_.invented;
        if (mixed) ++cell_.false_chamfers;
        cell_.notes.push_back(text("%s: %zu points, %.1f mm2, on true face %d", mixed ? "mixed" : "twice",
                                   face.points, face.area_mm2, best == votes.end() ? -1 : best->first + 1));
        continue;
      }
      const auto f = static_cast<size_t>(best->first);
      ++times[f];
      ++(is_wanted(truth_[f]) ? cell_.found : cell_.other_found);
      compare_plane(f, face);
    }
    for (size_t f = 0; f < truth_.size(); ++f) {
      if (!is_wanted(truth_[f])) continue;
      ++cell_.wanted;
      if (times[f] == 0)
        cell_.notes.push_back(text("missed: face %zu, %zu points, %.2f mm wide (%.1f spacings), %.1f mm2",
                                   f + 1, truth_[f].points, truth_[f].width_mm,
                                   truth_[f].width_mm / cell_.spacing_mm, solid_.faces()[f].area_mm2));
    }
  }

  void compare_plane(size_t f, const Face& face) {
    const Face& model = solid_.faces()[f];
    const Vec3 normal = T_.R * model.normal, point = T_ * truth_[f].middle;
    const double sigma = options_.sigma_mm, n = static_cast<double>(truth_[f].points);
    const double offset = face.normal.dot(point) - face.d_mm;
    const double allowed = 3 * sigma / std::sqrt(n) + 0.02 * sigma +
                           0.5 * sigma * sigma * truth_[f].perimeter_mm / model.area_mm2;
    const double tilt = 1e3 * face.normal.cross(normal).norm();
    const double area = face.area_mm2 / model.area_mm2 - 1;
    if (is_wanted(truth_[f])) {
      cell_.worst_offset = std::max(cell_.worst_offset, std::abs(offset) / allowed);
      cell_.worst_tilt_mrad = std::max(cell_.worst_tilt_mrad, tilt);
      if (std::abs(area) > std::abs(cell_.worst_area)) cell_.worst_area = area;
      if (std::abs(offset) > allowed) {
        ++cell_.offsets_missed;
        cell_.notes.push_back(
            text("offset: face %zu, %zu of %zu points, %.1f spacings wide, %+.4f mm, %.1f of what is allowed",
                 f + 1, face.points, truth_[f].points, truth_[f].width_mm / cell_.spacing_mm, -offset,
                 std::abs(offset) / allowed));
      }
      if (std::abs(area) > 0.02)
        cell_.notes.push_back(text("area: face %zu, %.1f mm2, %+.1f %%", f + 1, model.area_mm2, 100 * area));
    }
  }

  void compare_volumes(const Reconstruction& reconstruction, const MeasuredFaces& faces) {
    cell_.boundary_volume = faces.volume_mm3 / solid_.volume_mm3 - 1;
    double edges_mm = 0;
    for (const TrueFace& face : truth_) edges_mm += 0.5 * face.perimeter_mm;
    // A mesh cuts corners: its last vertices stand up to a spacing from the edge on either side, half of one
    // on average, and the triangle cut off has at most half their product.
    const double h = reconstruction.vertex_spacing_mm;
    const double allowed = 0.5 * options_.sigma_mm * solid_.area_mm2 + 0.125 * h * h * edges_mm;
    cell_.mesh_volume = (reconstruction.volume_mm3 - solid_.volume_mm3) / allowed;
    if (std::abs(cell_.mesh_volume) > 1)
      cell_.notes.push_back(
          text("tetrahedra: volume %+.3f %%", 100 * (reconstruction.volume_mm3 / solid_.volume_mm3 - 1)));
  }

  // What no beam saw counts as solid: so much of it there is, from the true model alone.
  void explain(const Scan& scan, double max_incidence_rad) {
    cell_.dark = dark_air_mm3(solid_, caster_, scan, T_, max_incidence_rad) / solid_.volume_mm3;
    const std::vector<double> share = dark_share(solid_, caster_, scan, T_, max_incidence_rad);
    std::string faces;
    for (size_t f = 0; f < share.size(); ++f) {
      if (share[f] >= 0.02) faces += text(" %zu: %.0f %%", f + 1, 100 * share[f]);
    }
    cell_.notes.push_back(text("shadow: air that no view sees, %.3f %% of the volume; dark share of faces%s",
                               100 * cell_.dark, faces.empty() ? " none" : faces.c_str()));
  }

  Status save(const Scan& scan) const {
    const std::filesystem::path folder = options_.save_to;
    std::filesystem::create_directories(folder);
    return write_scan(folder / text("%s-%g-%zu.ply", cell_.part.c_str(), options_.sigma_mm, options_.points),
                      scan);
  }

  const Solid& solid_;
  const CellOptions& options_;
  Cell& cell_;
  RigidTransform T_;
  RayCaster caster_;
  std::vector<TrueFace> truth_;
  std::vector<int> hit_face_;
};

}  // namespace

Result<Solid> solid_of(const BenchPart& part) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("tetragauge-matrix-" + std::to_string(getpid()) + ".csg");
  if (Status status = write_whole_file(path, part.csg); !status) return status.error();
  Result<Solid> solid = read_solid(path);
  std::filesystem::remove(path);
  return solid;
}

Result<Cell> measure_cell(const std::string& name, const Solid& solid, const CellOptions& options) {
  Cell cell;
  cell.part = name;
  cell.sigma_mm = options.sigma_mm;
  if (Status status = Comparison(solid, options, cell).run(); !status) return status.error();
  return cell;
}

}  // namespace tetragauge::bench
