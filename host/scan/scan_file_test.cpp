// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/scan/scan_file.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "host/base/whole_file.hpp"

namespace tetragauge {
namespace {

class ScanFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("tetragauge_" + std::string(info->name()) + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path put(const std::string& name, const std::string& content) {
    const std::filesystem::path path = folder_ / name;
    EXPECT_TRUE(write_whole_file(path, content).ok());
    return path;
  }
  // The error's message, or "" when the file was read.
  std::string error_of(const std::string& name, const std::string& content,
                       const ReadScanOptions& options = {}) {
    const Result<Scan> scan = read_scan(put(name, content), options);
    if (scan) return "";
    EXPECT_EQ(scan.error().kind, ErrorKind::bad_input);
    return scan.error().message;
  }

  std::filesystem::path folder_;
};

Scan small_scan() {
  Scan scan;
  scan.header.machine_id = "emulated";
  scan.header.u_cal_mm = 0.004;
  scan.header.spot_mm = 0.2;
  scan.header.seed = 18446744073709551615ull;
  for (int i = 0; i < 3; ++i) {
    scan.points.emplace_back(i / 3.0, -1e-9 * i, 40 + i);
    scan.ray_origins.emplace_back(350, i, 200);
    scan.sigma_mm.push_back(0.03f);
    scan.intensity.push_back(0.5f);
    scan.view.push_back(7);
    scan.flags.push_back(static_cast<uint32_t>(i));
  }
  scan.rejected.push_back({Vec3(1, 2, 3), Vec3(0, 0, -1), 4, 5});
  return scan;
}

const std::string kAsciiHeader =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty "
    "float ray_x\n"
    "property float ray_y\nproperty float ray_z\nproperty float sigma\nend_header\n";

TEST_F(ScanFile, comes_back_bit_for_bit) {
  const Scan scan = small_scan();
  ASSERT_TRUE(write_scan(folder_ / "a.ply", scan).ok());
  const Result<Scan> back = read_scan(folder_ / "a.ply");
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(scan_to_ply(*back), scan_to_ply(scan));
  EXPECT_EQ(back->header.seed, scan.header.seed);
  EXPECT_EQ(back->header.spot_mm, 0.2);
  EXPECT_EQ(back->points[1], scan.points[1]);
  EXPECT_EQ(back->rejected.at(0).reason, 4u);
}

TEST_F(ScanFile, has_the_size_its_header_says) {
  // Oracle: the layout of DESIGN section 4: 6 doubles, 2 floats, 2 uints a point; 6 doubles, 2 uints a beam.
  const std::string ply = scan_to_ply(small_scan());
  const size_t body = ply.find("end_header\n") + std::strlen("end_header\n");
  EXPECT_EQ(ply.size() - body, 3u * (6 * 8 + 4 * 4) + 1u * (6 * 8 + 2 * 4));
  double y2 = 0;  // the second coordinate of the third point, where the header says it lies
  std::memcpy(&y2, ply.data() + body + 2 * 64 + 8, 8);
  EXPECT_EQ(y2, -2e-9);
}

TEST_F(ScanFile, every_truncation_is_an_error) {
  const std::string ply = scan_to_ply(small_scan());
  for (size_t size = 0; size < ply.size(); ++size) {
    EXPECT_NE(error_of("cut.ply", ply.substr(0, size)), "") << size << " of " << ply.size() << " bytes";
  }
}

TEST_F(ScanFile, errors_name_the_place) {
  EXPECT_NE(error_of("nan.ply", kAsciiHeader + "1 2 3 0 0 9 0.1\n1 nan 3 0 0 9 0.1\n").find("point 1"),
            std::string::npos);
  EXPECT_NE(error_of("word.ply", kAsciiHeader + "1 2 3 0 0 9 0.1\n1 two 3 0 0 9 0.1\n").find("vertex 1"),
            std::string::npos);
  EXPECT_NE(error_of("sigma.ply", kAsciiHeader + "1 2 3 0 0 9 0.1\n1 2 3 0 0 9 -1\n").find("sigma"),
            std::string::npos);
  EXPECT_NE(error_of("ray.ply", kAsciiHeader + "1 2 3 1 2 3 0.1\n1 2 3 0 0 9 1\n").find("ray"),
            std::string::npos);
  EXPECT_NE(error_of("big.ply",
                     "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n"
                     "property double x\nend_header\n")
                .find("truncated"),
            std::string::npos);
  EXPECT_NE(error_of("text.ply", "hello").find("not a PLY"), std::string::npos);
  EXPECT_NE(error_of("none.ply",
                     "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
                     "property float z\nend_header\n")
                .find("0 points"),
            std::string::npos);
  EXPECT_NE(error_of("norays.xyz", "0 0 0\n1 0 0\n", {.sigma_mm = 0.1}).find("--ray-origin"),
            std::string::npos);
  EXPECT_NE(error_of("nosigma.xyz", "0 0 0\n1 0 0\n", {.ray_origin_mm = Vec3(0, 0, 9)}).find("--sigma"),
            std::string::npos);
  EXPECT_NE(error_of("short.xyz", "0 0 0\n1 0\n").find(":2:"), std::string::npos);
  EXPECT_NE(error_of("a.doc", "0 0 0\n").find("ending"), std::string::npos);
  const Result<Scan> missing = read_scan(folder_ / "missing.ply");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("missing.ply"), std::string::npos);
}

// What the fuzzer's properties found, and counts that do not fit what is there.
TEST_F(ScanFile, broken_numbers_and_counts_are_errors) {
  const std::string with_intensity =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property float ray_x\nproperty float ray_y\nproperty float ray_z\nproperty float sigma\n"
      "property double intensity\nproperty double view\nend_header\n";
  EXPECT_EQ(error_of("good.ply", with_intensity + "1 2 3 0 0 9 0.1 1 0\n"), "");
  EXPECT_NE(error_of("nan.ply", with_intensity + "1 2 3 0 0 9 0.1 nan 0\n").find("intensity"),
            std::string::npos);
  EXPECT_NE(error_of("far.ply", with_intensity + "1 2 3 0 0 9 0.1 1e300 0\n").find("intensity"),
            std::string::npos);
  EXPECT_NE(error_of("half.ply", with_intensity + "1 2 3 0 0 9 0.1 1 1.5\n").find("whole"),
            std::string::npos);
  EXPECT_NE(error_of("ray.ply", with_intensity + "1 2 3 1e200 0 9 0.1 1 0\n").find("point 0: its ray"),
            std::string::npos);
  EXPECT_NE(error_of("thin.ply", with_intensity + "1 2 3 0 0 9 1e-300 1 0\n").find("sigma"),
            std::string::npos);
  EXPECT_NE(error_of("more.ply", with_intensity + "1 2 3 0 0 9 0.1 1 0\n4 5 6 0 0 9 0.1 1 0\n")
                .find("bytes follow"),
            std::string::npos);
  EXPECT_NE(
      error_of("more_binary.ply", scan_to_ply(small_scan()) + std::string(64, '\0')).find("64 bytes follow"),
      std::string::npos);
  EXPECT_NE(error_of("twice.csv", "x,y,z,x\n1,2,3,4\n").find("'x' stands there twice"), std::string::npos);
  const std::string pcd = "FIELDS x y z\nPOINTS 2\nDATA ascii\n";
  EXPECT_NE(error_of("less.pcd", pcd + "1 2 3\n\n# no point\n").find("2 points announced, 1 there"),
            std::string::npos);
  EXPECT_NE(error_of("more.pcd", pcd + "1 2 3\nnan nan nan\n7 8 9\n").find("2 points announced, 3 there"),
            std::string::npos);
}

TEST_F(ScanFile, of_a_file_of_another_kind_the_error_is_short_and_plain) {
  std::string bytes = "7";
  for (int i = 0; i < 100'000; ++i) bytes += static_cast<char>(i % 251 == 10 ? 11 : i % 251);
  for (const char* name : {"a.ply", "a.pcd", "a.xyz", "a.csv"}) {
    for (const std::string& content :
         {bytes, "ply\n" + bytes, "x y z\n" + bytes, "FIELDS " + bytes, "1 2 " + bytes}) {
      const std::string message = error_of(name, content);
      EXPECT_NE(message, "");
      EXPECT_LT(message.size(), folder_.string().size() + 300);
      for (const char c : message) EXPECT_TRUE(c >= ' ' && c <= '~') << name << ": " << static_cast<int>(c);
    }
  }
}

TEST_F(ScanFile, clouds_of_others_get_rays_sigma_and_unit) {
  const ReadScanOptions options{.unit_scale_mm = 1000.0, .ray_origin_mm = Vec3(0, 0, 0), .sigma_mm = 2.0};
  const Result<Scan> scan = read_scan(put("tls.xyz", "0.5,1,2\r\n-0.5;1;2\n\n# end\n"), options);
  ASSERT_TRUE(scan.ok()) << scan.error().message;
  ASSERT_EQ(scan->size(), 2u);
  EXPECT_EQ(scan->points[1], Vec3(-500, 1000, 2000));
  EXPECT_NEAR((scan->ray_direction(0) - Vec3(1, 2, 4) / std::sqrt(21.0)).norm(), 0, 1e-15);
  EXPECT_EQ(scan->sigma_mm[0], 2.0f);

  const Result<Scan> parallel =
      read_scan(put("p.csv", "x,y,z\n1,2,3\n"), {.ray_direction = Vec3(0, 0, -2), .sigma_mm = 1.0});
  ASSERT_TRUE(parallel.ok()) << parallel.error().message;
  EXPECT_NEAR((parallel->ray_direction(0) - Vec3(0, 0, -1)).norm(), 0, 1e-15);

  const Result<Scan> pcd = read_scan(
      put("n.pcd",
          "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F "
          "F F\n"
          "COUNT 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 1 1 0 0 1\nnan nan nan 0 0 1\n"),
      {.sigma_mm = 1.0});
  ASSERT_TRUE(pcd.ok()) << pcd.error().message;
  ASSERT_EQ(pcd->size(), 1u);
  EXPECT_NEAR((pcd->ray_direction(0) - Vec3(0, 0, -1)).norm(), 0, 1e-15);
}

}  // namespace
}  // namespace tetragauge
