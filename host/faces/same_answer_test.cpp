// SPDX-License-Identifier: GPL-3.0-or-later
// The same points give the same bytes, in whatever order they come and on however many threads.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <string>

#include "host/faces/find_faces.hpp"
#include "host/reconstruct/synthetic_scan.hpp"

namespace tetragauge {
namespace {

class Bytes {
 public:
  template <typename Number>
  void put(Number number) {
    text_.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }
  void put(const Vec3& p) {
    for (int k = 0; k < 3; ++k) put(p[k]);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// All but face_points, which count along the scan.
std::string bytes_of(const MeasuredFaces& measured) {
  Bytes bytes;
  for (size_t k = 0; k < measured.faces().size(); ++k) {
    const Face& f = measured.faces()[k];
    bytes.put(f.id);
    bytes.put(f.surface);
    bytes.put(f.normal);
    bytes.put(f.d_mm);
    bytes.put(f.point_mm);
    bytes.put(f.area_mm2);
    bytes.put(f.points);
    for (int i = 0; i < 9; ++i) bytes.put(f.covariance->matrix(i / 3, i % 3));
    for (const int n : f.neighbours) bytes.put(n);
    bytes.put(measured.rms_mm[k]);
    for (const uint32_t t : measured.face_triangles[k]) bytes.put(t);
    for (const BoundaryLoop& loop : measured.boundaries[k]) {
      for (const BoundaryEdge& edge : loop) {
        bytes.put(edge.from_mm);
        bytes.put(edge.beyond);
      }
    }
  }
  bytes.put(measured.volume_mm3);
  bytes.put(measured.points_used);
  bytes.put(measured.points_rejected);
  bytes.put(measured.false_chamfers_dropped);
  return bytes.text();
}

std::string faces_of(const Scan& scan, size_t threads, ClusterMethod method) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const auto reconstruction = reconstruct(scan);
  EXPECT_TRUE(reconstruction.ok());
  FindFacesOptions options;
  options.cluster = method;
  const auto faces = find_faces(scan, *reconstruction, options);
  EXPECT_TRUE(faces.ok());
  for (size_t k = 0; k < faces->faces().size(); ++k) {
    const Face& f = faces->faces()[k];
    for (const uint32_t i : faces->face_points[k])
      EXPECT_LT(std::abs(f.normal.dot(scan.points[i]) - f.d_mm), 0.5) << "not a point of this scan's order";
  }
  return bytes_of(*faces);
}

TEST(SameAnswer, ForShufflesAndThreads) {
  synthetic::ScanPlan plan;
  plan.centre = Vec3(40, 30, 30);
  plan.half_width_mm = 62;
  plan.pitch_mm = 6;
  plan.sigma_mm = 0.05;
  const Scan scan = synthetic::scan_part(synthetic::staircase(), plan);
  for (const ClusterMethod method : {ClusterMethod::grow, ClusterMethod::normals, ClusterMethod::slink}) {
    const std::string expected = faces_of(scan, 1, method);
    ASSERT_GT(expected.size(), 15 * sizeof(double));
    for (const size_t threads : {1, 2, 7}) {
      EXPECT_EQ(faces_of(synthetic::shuffled(scan, threads), threads, method), expected)
          << threads << " threads, method " << static_cast<int>(method);
    }
  }
}

}  // namespace
}  // namespace tetragauge
