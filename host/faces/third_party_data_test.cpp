// SPDX-License-Identifier: GPL-3.0-or-later
// Real scans and certified fits made by others, from the folder `shared` beside the checkout; skipped without
// it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "host/faces/find_faces.hpp"
#include "host/geometry/fit_plane.hpp"
#include "host/scan/scan_file.hpp"

namespace tetragauge {
namespace {

namespace fs = std::filesystem;

const fs::path kShared = TETRAGAUGE_SHARED;

TEST(ThirdPartyData, NistReferencePlanesAgreeToNineDigits) {
  const fs::path folder = kShared / "data/fit_nist_l2/Plane";
  if (!fs::exists(folder)) GTEST_SKIP() << "no " << folder;
  size_t pairs = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".ds") continue;
    std::ifstream data(entry.path()), certified(fs::path(entry.path()).replace_extension(".fit"));
    size_t count = 0;
    data >> count;
    std::vector<Vec3> points;
    for (Vec3 p; data >> p.x() >> p.y() >> p.z();) points.push_back(p);
    ASSERT_EQ(points.size(), count) << entry.path();
    Vec3 point, normal;
    certified >> point.x() >> point.y() >> point.z() >> normal.x() >> normal.y() >> normal.z();
    ASSERT_TRUE(certified) << entry.path();
    normal.normalize();

    const auto fit = fit_plane(points, {}, normal);
    ASSERT_TRUE(fit) << entry.path();
    Vec3 low = points[0], high = points[0];
    for (const Vec3& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    // Nine correct digits of the angle and of the distance relative to the size of the set.
    EXPECT_LT(fit->normal.cross(normal).norm(), 1e-9) << entry.path();
    EXPECT_LT(std::abs(fit->normal.dot(point) - fit->d_mm), 1e-9 * (high - low).norm()) << entry.path();
    ++pairs;
  }
  EXPECT_EQ(pairs, 15u);
}

// Steel plates on a table under a laser-line sensor: two parallel planes 10.0 to 10.4 mm apart (SOURCES.md).
TEST(ThirdPartyData, PlateAndTableOfSixLaserLineScans) {
  const fs::path folder = kShared / "data/scans/saxion_plates_laserline/plate01",
                 tool = kShared / "tools/saxion_to_ply.py";
  if (!fs::exists(folder) || !fs::exists(tool)) GTEST_SKIP() << "no " << folder;
  std::vector<double> heights;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".png") continue;
    SCOPED_TRACE(entry.path().filename().string());
    const fs::path ply = fs::temp_directory_path() / ("tetragauge-faces-" + std::to_string(getpid()) + "-" +
                                                      entry.path().stem().string() + ".ply");
    const std::string command = "python3 '" + tool.string() + "' '" + entry.path().string() + "' '" +
                                ply.string() + "' --step 5 > /dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const auto scan = read_scan(ply);
    fs::remove(ply);
    ASSERT_TRUE(scan.ok()) << scan.error().message;
    const auto reconstruction = reconstruct(*scan);
    ASSERT_TRUE(reconstruction.ok()) << reconstruction.error().message;
    EXPECT_EQ(reconstruction->rays_lost, 0u);
    EXPECT_TRUE(reconstruction->closed);
    const auto faces = find_faces(*scan, *reconstruction);
    ASSERT_TRUE(faces.ok());

    // The plate's top is the largest face of about 23,000 mm2 that lies high; the table is the largest of
    // all.
    const Face& table = faces->faces().front();
    const auto top = std::find_if(faces->faces().begin(), faces->faces().end(), [&](const Face& f) {
      return f.area_mm2 > 15000 && table.normal.dot(f.point_mm) - table.d_mm > 5;
    });
    ASSERT_NE(top, faces->faces().end());
    const double height = table.normal.dot(top->point_mm) - table.d_mm;
    EXPECT_GT(height, 10.0);
    EXPECT_LT(height, 10.4);
    EXPECT_LT(table.normal.cross(top->normal).norm(), 0.25 * M_PI / 180);
    EXPECT_NEAR(top->area_mm2, 23000, 1000);
    heights.push_back(height);
  }
  ASSERT_EQ(heights.size(), 6u);
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  EXPECT_LT(*high - *low, 0.25);
}

}  // namespace
}  // namespace tetragauge
