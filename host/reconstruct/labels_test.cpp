// SPDX-License-Identifier: GPL-3.0-or-later
// What comes with the surface: doubtful tetrahedra, the thesis's eliminations, resting positions, files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "host/reconstruct/mesh_file.hpp"
#include "host/reconstruct/reconstruct.hpp"
#include "host/reconstruct/resting_positions.hpp"
#include "host/reconstruct/synthetic_scan.hpp"
#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

using synthetic::ScanPlan;

ScanPlan plan_around(const Vec3& centre, double half_width_mm, double pitch_mm, double sigma_mm) {
  ScanPlan plan;
  plan.centre = centre;
  plan.half_width_mm = half_width_mm;
  plan.pitch_mm = pitch_mm;
  plan.sigma_mm = sigma_mm;
  return plan;
}

Reconstruction reconstructed(const Scan& scan, const ReconstructOptions& options = {}) {
  Result<Reconstruction> r = reconstruct(scan, options);
  EXPECT_TRUE(r.ok());
  return r.ok() ? std::move(*r) : Reconstruction{};
}

double distance_to_boundary(const synthetic::Prism& prism, const Vec3& p) {
  double nearest = std::min(p.y(), prism.length - p.y());
  for (size_t i = 0; i < prism.polygon.size(); ++i) {
    const Eigen::Vector2d a = prism.polygon[i], e = prism.polygon[(i + 1) % prism.polygon.size()] - a;
    const Eigen::Vector2d r = Eigen::Vector2d(p.x(), p.z()) - a;
    nearest = std::min(nearest, (r - std::clamp(r.dot(e) / e.squaredNorm(), 0.0, 1.0) * e).norm());
  }
  return nearest;
}

// A box over which the views from below are missing: what is in doubt lies at its underside, and is to be
// looked at from below.
TEST(Doubtful, IsRankedAndSaysFromWhereToLook) {
  ScanPlan plan = plan_around(Vec3(25, 20, 15), 40, 1.5, 0.02);
  std::erase_if(plan.views, [](const Vec3& v) { return v.z() < 0.3; });
  const Reconstruction r = reconstructed(synthetic::scan_part(synthetic::box(50, 40, 30), plan));
  ASSERT_GT(r.doubtful_ranked.size(), 3u);
  EXPECT_EQ(r.doubtful, r.doubtful_ranked.size());
  double last = INFINITY;
  for (const DoubtfulTetrahedron& d : r.doubtful_ranked) {
    EXPECT_LE(d.volume_mm3, last);
    last = d.volume_mm3;
    EXPECT_GT(d.volume_mm3, 0);
    EXPECT_GT(d.face_area_mm2, 0);
    EXPECT_NEAR(d.look_from.norm(), 1, 1e-9);
  }
  // The largest are looked at from where nobody has looked.
  for (size_t k = 0; k < 3; ++k) {
    const DoubtfulTetrahedron& d = r.doubtful_ranked[k];
    EXPECT_FALSE(d.is_air);
    for (const Vec3& view : plan.views) EXPECT_LT(d.look_from.dot(view), 0.2) << d.look_from.transpose();
  }
}

TEST(Doubtful, CellsCarryTheSameLabelsAsTheCounts) {
  ReconstructOptions options;
  options.keep_tetrahedra = true;
  const synthetic::Prism part = synthetic::box(50, 40, 30);
  const Reconstruction r =
      reconstructed(synthetic::scan_part(part, plan_around(Vec3(25, 20, 15), 40, 3, 0.02)), options);
  ASSERT_EQ(r.cells.size(), r.tetrahedra);
  size_t air = 0, doubtful = 0;
  double solid_mm3 = 0;
  for (const LabelledTetrahedron& cell : r.cells) {
    air += cell.is_air;
    doubtful += cell.is_doubtful;
    const Vec3& a = r.vertices[cell.vertex[0]];
    const double volume = (r.vertices[cell.vertex[1]] - a)
                              .cross(r.vertices[cell.vertex[2]] - a)
                              .dot(r.vertices[cell.vertex[3]] - a) /
                          6;
    EXPECT_GT(volume, 0);
    if (!cell.is_air) solid_mm3 += volume;
    // Far from the noise layer the label is what the box says.
    Vec3 centroid = Vec3::Zero();
    for (const uint32_t v : cell.vertex) centroid += 0.25 * r.vertices[v];
    if (distance_to_boundary(part, centroid) > 2 * r.vertex_spacing_mm) {
      EXPECT_EQ(cell.is_air,
                !(part.covers(centroid.x(), centroid.z()) && centroid.y() > 0 && centroid.y() < 40));
    }
  }
  EXPECT_EQ(air, r.air);
  EXPECT_EQ(doubtful, r.doubtful);
  EXPECT_NEAR(solid_mm3, r.volume_mm3, 1e-6 * r.volume_mm3);
  for (const DoubtfulTetrahedron& d : r.doubtful_ranked) {
    EXPECT_TRUE(r.cells[d.cell].is_doubtful);
    EXPECT_EQ(r.cells[d.cell].is_air, d.is_air);
  }
}

// A brick lies on any of its six sides; how steadily follows from its sizes.
TEST(RestingPositions, OfABrick) {
  const Reconstruction r = reconstructed(
      synthetic::scan_part(synthetic::box(50, 40, 30), plan_around(Vec3(25, 20, 15), 40, 1.5, 0.02)));
  const auto positions = resting_positions(r);
  ASSERT_EQ(positions.size(), 6u);
  const double h = r.vertex_spacing_mm;
  size_t found = 0;
  for (const Vec3& down :
       {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    for (const RestingPosition& p : positions) {
      if (p.down.dot(down) < 0.99) continue;
      ++found;
      const Vec3 half(25, 20, 15);
      const double height = half.dot(down.cwiseAbs());
      double margin = INFINITY;
      for (int k = 0; k < 3; ++k) {
        if (down[k] == 0) margin = std::min(margin, half[k]);
      }
      EXPECT_NEAR(p.height_mm, height, 0.2);
      EXPECT_NEAR(p.margin_mm, margin, 2 * h);
      EXPECT_NEAR(p.tipping_rad, std::atan2(p.margin_mm, p.height_mm), 1e-12);
      EXPECT_GE(p.contact_mm.size(), 3u);
    }
  }
  EXPECT_EQ(found, 6u);
  for (size_t k = 1; k < positions.size(); ++k)
    EXPECT_GE(positions[k - 1].tipping_rad, positions[k].tipping_rad);
}

// A leaning prism whose centroid is not over its small foot cannot stand on it.
TEST(RestingPositions, NoneOnAFootThatTheCentroidIsNotOver) {
  synthetic::Prism leaning{{{0, 0}, {10, 0}, {60, 40}, {40, 40}}, 30};
  const Reconstruction r =
      reconstructed(synthetic::scan_part(leaning, plan_around(Vec3(30, 15, 20), 45, 1.5, 0.01)));
  const auto positions = resting_positions(r);
  EXPECT_GE(positions.size(), 3u);
  for (const RestingPosition& p : positions) EXPECT_GT((p.down - Vec3(0, 0, -1)).norm(), 0.1);
}

TEST(MeshFile, StlHasOneRecordPerTriangleAndNormalsOutOfTheMaterial) {
  const Reconstruction r = reconstructed(
      synthetic::scan_part(synthetic::box(50, 40, 30), plan_around(Vec3(25, 20, 15), 40, 4, 0.01)));
  const std::string stl = surface_to_stl(r);
  uint32_t count = 0;
  std::memcpy(&count, stl.data() + 80, 4);
  ASSERT_EQ(count, r.surface.size());
  ASSERT_EQ(stl.size(), 84 + 50 * r.surface.size());
  // Divergence theorem over what the file says: the volume, positive only with outward triangles.
  double volume = 0;
  for (uint32_t t = 0; t < count; ++t) {
    float f[12];
    std::memcpy(f, stl.data() + 84 + 50 * t, sizeof f);
    const auto at = [&](int k) { return Eigen::Map<const Eigen::Vector3f>(f + 3 * k).cast<double>().eval(); };
    volume += at(1).cross(at(2)).dot(at(3)) / 6;
    const Vec3 n = (at(2) - at(1)).cross(at(3) - at(1));
    if (n.norm() > 1e-3) {
      EXPECT_GT(n.normalized().dot(at(0)), 0.99);
    }
  }
  EXPECT_NEAR(volume, r.volume_mm3, 1e-3 * r.volume_mm3);
}

// The thesis's staircase has a deep groove that six views along the axes leave full of webs. No solid is left
// to which an axis has free sight, judged on the analytic part.
TEST(Carve, EliminationsLeaveNoTetrahedronThatAnAxisSees) {
  const synthetic::Prism part = synthetic::staircase();
  ScanPlan plan = plan_around(Vec3(40, 30, 30), 60, 3, 0.01);
  plan.views = {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)};
  const Scan scan = synthetic::scan_part(part, plan);
  const Solid solid = test::solid_from_csg(test::kStaircase);
  const RayCaster caster(solid);
  ReconstructOptions options;
  options.method = ReconstructMethod::carve;
  options.keep_tetrahedra = true;
  const Reconstruction without = reconstructed(scan, options);
  options.model = &caster;
  const Reconstruction with = reconstructed(scan, options);
  EXPECT_TRUE(with.closed);
  EXPECT_EQ(with.rays_lost, 0u);
  size_t solid_cells = 0;
  for (const LabelledTetrahedron& cell : with.cells) {
    if (cell.is_air) continue;
    ++solid_cells;
    Vec3 centroid = Vec3::Zero();
    for (const uint32_t v : cell.vertex) centroid += 0.25 * with.vertices[v];
    if (part.covers(centroid.x(), centroid.z()) && distance_to_boundary(part, centroid) > 1e-3) continue;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        const Vec3 direction = -side * Vec3::Unit(axis);
        const auto hit = part(centroid - 500 * direction, direction);
        EXPECT_TRUE(hit && *hit < 500 + 1e-3) << centroid.transpose();
      }
    }
  }
  EXPECT_GT(solid_cells, 1000u);
  double area_mm2 = 0;
  for (size_t i = 0; i < part.polygon.size(); ++i) {
    const Eigen::Vector2d &a = part.polygon[i], &b = part.polygon[(i + 1) % part.polygon.size()];
    area_mm2 += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  const double volume = area_mm2 * part.length;
  EXPECT_LE(std::abs(with.volume_mm3 - volume), std::abs(without.volume_mm3 - volume));
  options.method = ReconstructMethod::cut;
  EXPECT_EQ(reconstruct(scan, options).error().kind, ErrorKind::usage);
}

// Whether p lies in solid: the label of a cell that contains it, by brute force.
bool is_solid_at(const Reconstruction& r, const Vec3& p) {
  for (const LabelledTetrahedron& cell : r.cells) {
    bool inside = true;
    for (size_t i = 0; i < 4 && inside; ++i) {
      std::array<Vec3, 4> v;
      for (size_t k = 0; k < 4; ++k) v[k] = r.vertices[cell.vertex[k]];
      v[i] = p;
      inside = (v[1] - v[0]).cross(v[2] - v[0]).dot(v[3] - v[0]) >= 0;
    }
    if (inside) return !cell.is_air;
  }
  return false;  // outside the hull
}

// Walls down to max(6 sigma, one spacing) stay, and so does the air between two of them.
TEST(ThinWalls, StayWholeAndApart) {
  for (const auto& [wall_mm, sigma_mm] : {std::pair{2.0, 0.1}, {1.0, 0.1}, {2.0, 0.03}}) {
    ScanPlan plan = plan_around(Vec3(wall_mm / 2, 15, 10), 22, 0.8, sigma_mm);
    ReconstructOptions options;
    options.keep_tetrahedra = true;
    const Reconstruction r =
        reconstructed(synthetic::scan_part(synthetic::box(wall_mm, 30, 20), plan), options);
    ASSERT_GE(wall_mm, std::max(6 * sigma_mm, r.point_spacing_mm));
    for (int i = 0; i < 60; ++i) {
      const Vec3 p(wall_mm / 2, 3 + 24.0 * (i % 10) / 9, 3 + 14.0 * (i / 10) / 5);
      EXPECT_TRUE(is_solid_at(r, p)) << wall_mm << " mm at sigma " << sigma_mm << ": " << p.transpose();
    }
    // Edges cut off by h each way, the noise layer half a sigma.
    const double h = r.vertex_spacing_mm, volume = wall_mm * 600, area = 2 * (600 + 50 * wall_mm);
    EXPECT_NEAR(r.volume_mm3, volume, 0.5 * sigma_mm * area + 0.5 * h * wall_mm * 2 * (30 + 20)) << wall_mm;
  }
}

TEST(ThinWalls, AGapOfOneMillimetreStaysOpen) {
  // Two blocks, 1 mm apart, 3 mm deep, on one foot.
  const synthetic::Prism part{{{0, 0}, {21, 0}, {21, 10}, {11, 10}, {11, 7}, {10, 7}, {10, 10}, {0, 10}}, 20};
  ScanPlan plan = plan_around(Vec3(10.5, 10, 5), 18, 0.5, 0.03);
  ReconstructOptions options;
  options.keep_tetrahedra = true;
  const Reconstruction r = reconstructed(synthetic::scan_part(part, plan), options);
  for (int i = 0; i < 20; ++i) {
    const double y = 2 + 16.0 * i / 19;
    EXPECT_FALSE(is_solid_at(r, Vec3(10.5, y, 9))) << y;
    EXPECT_TRUE(is_solid_at(r, Vec3(8, y, 8.5))) << y;
    EXPECT_TRUE(is_solid_at(r, Vec3(13, y, 8.5))) << y;
  }
}

std::vector<uint8_t> decode_base64(const std::string& text) {
  std::vector<uint8_t> bytes;
  uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char* at = std::strchr(letters, c);
    if (c == '=' || !at) break;
    group = group << 6 | static_cast<uint32_t>(at - letters);
    if ((bits += 6) >= 8) bytes.push_back(static_cast<uint8_t>(group >> (bits -= 8)));
  }
  return bytes;
}

TEST(MeshFile, VtuHoldsEveryCellAsParaViewReadsIt) {
  ReconstructOptions options;
  options.keep_tetrahedra = true;
  const Reconstruction r = reconstructed(
      synthetic::scan_part(synthetic::box(50, 40, 30), plan_around(Vec3(25, 20, 15), 40, 6, 0.01)), options);
  const std::string vtu = tetrahedra_to_vtu(r);
  const auto block = [&](const std::string& name) {
    const size_t tag = vtu.find("Name=\"" + name + "\"");
    EXPECT_NE(tag, std::string::npos) << name;
    const size_t begin = vtu.find('>', tag) + 1;
    std::vector<uint8_t> bytes = decode_base64(vtu.substr(begin, vtu.find('<', begin) - begin));
    uint64_t size = 0;
    EXPECT_GE(bytes.size(), sizeof size);
    std::memcpy(&size, bytes.data(), sizeof size);
    EXPECT_EQ(size, bytes.size() - sizeof size) << name;
    return std::vector<uint8_t>(bytes.begin() + sizeof size, bytes.end());
  };
  ASSERT_EQ(block("Points").size(), 24 * r.vertices.size());
  const std::vector<uint8_t> connectivity = block("connectivity"), label = block("label");
  ASSERT_EQ(connectivity.size(), 32 * r.tetrahedra);
  ASSERT_EQ(block("offsets").size(), 8 * r.tetrahedra);
  ASSERT_EQ(block("types"), std::vector<uint8_t>(r.tetrahedra, 10));  // VTK_TETRA
  ASSERT_EQ(block("air_rays").size(), 4 * r.tetrahedra);
  ASSERT_EQ(label.size(), r.tetrahedra);
  EXPECT_EQ(static_cast<size_t>(std::count(label.begin(), label.end(), 1)), r.solid);
  for (size_t c = 0; c < r.tetrahedra; ++c) {
    for (size_t k = 0; k < 4; ++k) {
      int64_t v = -1;
      std::memcpy(&v, connectivity.data() + 32 * c + 8 * k, sizeof v);
      ASSERT_EQ(v, static_cast<int64_t>(r.cells[c].vertex[k]));
    }
  }
}

}  // namespace
}  // namespace tetragauge
