// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "host/base/whole_file.hpp"
#include "host/geometry/face_list_file.hpp"
#include "host/geometry/fit_plane.hpp"
#include "host/geometry/fit_plane_along_rays.hpp"
#include "host/geometry/rigid_transform.hpp"

namespace tetragauge {
namespace {

TEST(RigidTransform, follows_the_right_hand) {
  // Oracle: quarter turns by hand. z turns x to y, then y turns z to x, then x turns y to z.
  EXPECT_EQ(rotation_from_degrees(0, 0, 90) * Vec3(1, 0, 0), Vec3(0, 1, 0));
  EXPECT_EQ(rotation_from_degrees(0, 90, 0) * Vec3(0, 0, 1), Vec3(1, 0, 0));
  EXPECT_EQ(rotation_from_degrees(90, 0, 0) * Vec3(0, 1, 0), Vec3(0, 0, 1));
  // Rz Ry Rx: x first.
  EXPECT_EQ(rotation_from_degrees(90, 0, 90) * Vec3(0, 1, 0), Vec3(0, 0, 1));
}

TEST(RigidTransform, angles_come_back) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-179, 179);
  for (int i = 0; i < 1000; ++i) {
    const Mat3 R = rotation_from_degrees(angle(random), angle(random) / 2, angle(random));
    const Vec3 deg = degrees_from_rotation(R);
    EXPECT_NEAR((rotation_from_degrees(deg.x(), deg.y(), deg.z()) - R).norm(), 0, 1e-12);
  }
  const Mat3 pole = rotation_from_degrees(20, 90, 50);
  const Vec3 deg = degrees_from_rotation(pole);
  EXPECT_NEAR((rotation_from_degrees(deg.x(), deg.y(), deg.z()) - pole).norm(), 0, 1e-12);
  EXPECT_NEAR(rotation_angle(rotation_from_degrees(0, 0, 1e-7)), 1e-7 * std::numbers::pi / 180, 1e-20);
}

TEST(RigidTransform, reads_six_numbers_and_nothing_else) {
  const Result<RigidTransform> pose = parse_pose("90,0,0,1,-2,+3.5", "--pose");
  ASSERT_TRUE(pose.ok());
  EXPECT_EQ(pose->t, Vec3(1, -2, 3.5));
  for (const char* bad : {"", "1,2,3", "1,2,3,4,5,6,7", "1,2,3,4,5,x", "1,2,3,4,5,nan", "1 2 3 4 5 6"}) {
    const Result<RigidTransform> error = parse_pose(bad, "--pose");
    ASSERT_FALSE(error.ok()) << bad;
    EXPECT_EQ(error.error().kind, ErrorKind::usage);
  }
}

TEST(FitPlane, finds_an_exact_plane_far_from_the_origin) {
  const Vec3 n = Vec3(1, 2, -3).normalized();
  const auto [u, v] = tangent_frame(n);
  std::vector<Vec3> points;
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 10; ++k) points.push_back(n * 1234.5 + u * (500.0 + i) + v * (3.0 * k));
  }
  const auto fit = fit_plane(points, {}, n);
  ASSERT_TRUE(fit);
  EXPECT_NEAR((fit->normal - n).norm(), 0, 1e-12);
  EXPECT_NEAR(fit->d_mm, 1234.5, 1e-9);
  EXPECT_FALSE(fit_plane(std::vector<Vec3>{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {}, n));
  EXPECT_FALSE(fit_plane(std::vector<Vec3>(5, Vec3(1, 1, 1)), {}, n));
}

TEST(FitPlane, covariance_is_the_scatter_of_repeated_fits) {
  // Oracle: Monte Carlo on a 10 x 4 mm patch with sigma 0.01.
  const double sigma = 0.01;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, sigma);
  Mat3 scatter = Mat3::Zero();
  PlaneCovariance said;
  const int runs = 4000;
  for (int run = 0; run < runs; ++run) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 10; ++i) {
      for (int k = 0; k <= 4; ++k) points.emplace_back(i - 5, k - 2, noise(random));
    }
    const auto fit =
        fit_plane(points, std::vector<double>(points.size(), 1 / (sigma * sigma)), Vec3::UnitZ());
    ASSERT_TRUE(fit);
    said = fit->covariance;
    // A turn by (a about u, b about v) takes z to z + a (u x z) + b (v x z).
    const Vec3 turned = fit->normal - Vec3::UnitZ();
    const Vec3 e(fit->d_mm, turned.dot(said.u.cross(Vec3::UnitZ())), turned.dot(said.v.cross(Vec3::UnitZ())));
    scatter += e * e.transpose() / runs;
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::sqrt(scatter(k, k) / said.matrix(k, k)), 1, 0.05) << k;
}

TEST(FitPlaneAlongRays, a_strip_no_wider_than_the_noise_stays_upright) {
  // Oracle: the known plane and Monte Carlo. 0.6 mm wide, looked at 50 degrees across it, sigma 0.1 along the
  // ray: the errors' part along the plane is as large as the spread of the places.
  const Vec3 n = Vec3(0.3, -0.2, 0.9).normalized();
  const auto [u, v] = tangent_frame(n);
  const Vec3 direction = (std::sin(0.87) * u - std::cos(0.87) * n).normalized();
  const Vec3 corner(40, -20, 60);
  const double sigma = 0.1, across = sigma * std::cos(0.87);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, sigma);
  const int runs = 2000;
  Vec3 mean = Vec3::Zero();
  Mat3 scatter = Mat3::Zero(), said = Mat3::Zero();
  double leaning = 0;
  for (int run = 0; run < runs; ++run) {
    std::vector<Vec3> points;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 20; ++k)
        points.push_back(corner + 0.2 * i * u + 1.0 * k * v + noise(random) * direction);
    const std::vector<Vec3> directions(points.size(), direction);
    const std::vector<double> weights(points.size(), 1 / (across * across));
    const auto fit = fit_plane_along_rays(points, directions, weights, n);
    ASSERT_TRUE(fit);
    const Vec3 turned = fit->normal - n;
    const Vec3 e(n.dot(fit->centroid_mm - corner), turned.dot(fit->covariance.u.cross(n)),
                 turned.dot(fit->covariance.v.cross(n)));
    mean += e / runs;
    scatter += e * e.transpose() / runs;
    said += fit->covariance.matrix / runs;
    leaning += std::abs(fit_plane(points, weights, n)->normal.dot(u)) / runs;
  }
  // `mean` has the scatter of one run over sqrt(runs).
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(mean[k]), 4 * std::sqrt(said(k, k) / runs) + 0.02 * std::sqrt(said(k, k))) << k;
    EXPECT_NEAR(std::sqrt(scatter(k, k) / said(k, k)), 1, 0.05) << k;
  }
  EXPECT_GT(leaning,
            0.05);  // what a total fit makes of it, rad: some sigma^2 sin cos over the places' variance
}

TEST(FitPlaneAlongRays, exact_points_give_the_plane_from_a_start_far_off) {
  const Vec3 n = Vec3(1, 2, 2) / 3.0;
  const auto [u, v] = tangent_frame(n);
  std::vector<Vec3> points, directions;
  for (int i = 0; i < 5; ++i) {
    for (int k = 0; k < 5; ++k) {
      points.push_back(7.5 * n + 3.0 * i * u + 2.0 * k * v);
      directions.push_back((-n + 0.2 * i * u - 0.1 * k * v).normalized());
    }
  }
  const std::vector<double> weights(points.size(), 1.0);
  const auto fit = fit_plane_along_rays(points, directions, weights, (n + 0.4 * u).normalized());
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->normal - n).norm(), 1e-14);
  EXPECT_NEAR(fit->d_mm, 7.5, 1e-12);
  const std::vector<Vec3> line(5, Vec3(1, 2, 3));
  EXPECT_FALSE(fit_plane_along_rays(line, std::span(directions).first(5), std::span(weights).first(5), n));
  EXPECT_FALSE(fit_plane_along_rays({}, {}, {}, n));
}

class FaceListFile : public ::testing::Test {
 protected:
  std::filesystem::path put(const std::string& name, const std::string& content) {
    const auto path =
        std::filesystem::temp_directory_path() / ("tetragauge_" + std::to_string(::getpid()) + name);
    EXPECT_TRUE(write_whole_file(path, content).ok());
    files_.push_back(path);
    return path;
  }
  void TearDown() override {
    for (const auto& file : files_) std::filesystem::remove(file);
  }
  std::vector<std::filesystem::path> files_;
};

TEST_F(FaceListFile, hsp_is_scaled_and_signed) {
  const Result<FaceList> list =
      read_face_list(put("a.hsp", "# cm\n4  2 0 0  -16.0  12.0 # twice the unit normal\n\n"), 10.0);
  ASSERT_TRUE(list.ok()) << list.error().message;
  ASSERT_EQ(list->faces.size(), 1u);
  EXPECT_EQ(list->faces[0].id, 4);
  EXPECT_EQ(list->faces[0].normal, Vec3(1, 0, 0));
  EXPECT_DOUBLE_EQ(list->faces[0].d_mm, 80);
  EXPECT_DOUBLE_EQ(list->faces[0].area_mm2, 1200);
}

TEST_F(FaceListFile, broken_lists_name_file_and_line) {
  for (const char* bad :
       {"1 0 0 0 5 5\n", "1 1 0 0 5\n", "1 1 0 0 5 5 5\n", "x 1 0 0 5 5\n", "1 1 0 0 nan 5\n",
        "1 1e200 0 1e200 5 5\n", "1 1e-8 0 0 1e305 1\n", "1 1 0 0 0 1e300\n", "1 1 0 0 5 -5\n", "# nothing\n",
        "1 1 0 0 5 5\n1 0 1 0 5 5\n"}) {
    const Result<FaceList> list = read_face_list(put("b.hsp", bad), 1.0);
    ASSERT_FALSE(list.ok()) << bad;
    EXPECT_EQ(list.error().kind, ErrorKind::bad_input);
    EXPECT_NE(list.error().message.find("b.hsp"), std::string::npos);
  }
}

TEST_F(FaceListFile, json_comes_back) {
  FaceList list;
  Face face;
  face.id = 1;
  face.surface = 1;
  face.normal = Vec3(0, 0.6, -0.8);
  face.d_mm = -12.5;
  face.point_mm = Vec3(1, 2, 3);
  face.area_mm2 = 42;
  face.neighbours = {2, 3};
  face.points = 99;
  face.covariance = PlaneCovariance{Mat3::Identity() * 1e-6, Vec3::UnitX(), Vec3(0, 0.8, 0.6)};
  list.faces.push_back(face);
  const std::string text = face_list_to_json(list, "tetragauge/faces/1").dump();
  const Result<FaceList> back = read_face_list(put("c.json", text));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(face_list_to_json(*back, "tetragauge/faces/1").dump(), text);
  for (const char* bad : {"", "[]", "{}", "{\"faces\": []}", "{\"faces\": [{\"id\": 1, \"type\": \"blob\"}]}",
                          "{\"faces\": [{\"id\": 1, \"type\": \"plane\"}]}"}) {
    EXPECT_FALSE(read_face_list(put("d.json", bad)).ok()) << bad;
  }
  const auto plane = [&](const std::string& id, const std::string& normal, const std::string& rest) {
    const auto read = read_face_list(put("e.json", "{\"faces\": [{\"id\": " + id +
                                                       ", \"type\": \"plane\", \"normal\": " + normal +
                                                       ", \"d_mm\": 1" + rest + "}]}"));
    return read ? "" : read.error().message;
  };
  EXPECT_EQ(plane("1", "[0, 0, 2]", ", \"neighbours\": [2], \"points\": 3"), "");
  // A conversion to int would make 1 of each of these ids.
  for (const char* id : {"4294967297", "1.5", "\"1\"", "true"}) {
    EXPECT_NE(plane(id, "[0, 0, 1]", "").find("faces[0]: id is not a whole number"), std::string::npos) << id;
  }
  for (const char* normal : {"[0, 0, 0]", "[1e200, 0, 1e200]", "[0, 1]", "[0, 0, true]"})
    EXPECT_NE(plane("1", normal, ""), "") << normal;
  for (const char* rest : {", \"area_mm2\": -1", ", \"area_mm2\": 1e300", ", \"axis\": [0, 0, 0]",
                           ", \"neighbours\": [1e30]", ", \"points\": -1", ", \"d_mm\": 2"}) {
    EXPECT_NE(plane("1", "[0, 0, 1]", rest), "") << rest;
  }
}

}  // namespace
}  // namespace tetragauge
