// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files: bodies written here by hand, and CAD exports of others (shared/data/SOURCES.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>

#include "host/solid/ray_caster.hpp"
#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

using test::count;
using test::error_of;
using test::read_text;

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::vector<int>> faces;
};

// 10 x 20 x 30 at the origin, outward.
Mesh box(const Vec3& size = Vec3(10, 20, 30)) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.push_back(size.cwiseProduct(Vec3(i & 1, (i >> 1) & 1, i >> 2)));
  mesh.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  return mesh;
}

// A cylinder about z as exporters write it: strips of two triangles, and fans for the ends.
Mesh cylinder(double radius, double height, int sides) {
  Mesh mesh;
  for (int k = 0; k < 2 * sides; ++k) {
    const double phi = 2 * std::numbers::pi * (k % sides) / sides;
    mesh.vertices.emplace_back(radius * std::cos(phi), radius * std::sin(phi), k < sides ? 0 : height);
  }
  std::vector<int> bottom, top;
  for (int k = 0; k < sides; ++k) {
    const int next = (k + 1) % sides;
    mesh.faces.push_back({k, next, sides + next});
    mesh.faces.push_back({k, sides + next, sides + k});
    bottom.push_back(sides - 1 - k);
    top.push_back(sides + k);
  }
  mesh.faces.push_back(bottom);
  mesh.faces.push_back(top);
  return mesh;
}

std::vector<std::array<int, 3>> fans(const Mesh& mesh) {
  std::vector<std::array<int, 3>> triangles;
  for (const auto& face : mesh.faces) {
    for (size_t k = 1; k + 1 < face.size(); ++k) triangles.push_back({face[0], face[k], face[k + 1]});
  }
  return triangles;
}

std::string binary_stl(const Mesh& mesh) {
  std::string text(80, 's');
  text.replace(0, 6, "solid ");
  const auto triangles = fans(mesh);
  const uint32_t size = static_cast<uint32_t>(triangles.size());
  text.append(reinterpret_cast<const char*>(&size), 4);
  for (const auto& t : triangles) {
    text.append(12, '\0');
    for (const int corner : t) {
      for (int i = 0; i < 3; ++i) {
        const float x = static_cast<float>(mesh.vertices[static_cast<size_t>(corner)][i]);
        text.append(reinterpret_cast<const char*>(&x), 4);
      }
    }
    text.append(2, '\0');
  }
  return text;
}

std::string numbers(const Vec3& p) {
  return std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z());
}

std::string ascii_stl(const Mesh& mesh) {
  std::string text = "solid a part with a name\n";
  for (const auto& t : fans(mesh)) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const int corner : t)
      text += "   vertex " + numbers(mesh.vertices[static_cast<size_t>(corner)]) + "\n";
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid a part with a name\n";
}

std::string obj(const Mesh& mesh) {
  std::string text = "# made by hand\nmtllib none.mtl\no part\n";
  for (const Vec3& p : mesh.vertices) text += "v " + numbers(p) + "\n";
  text += "vn 0 0 1\ns off\n";
  for (const auto& face : mesh.faces) {
    text += "f";
    for (const int corner : face) text += " " + std::to_string(corner + 1) + "//1";
    text += "\n";
  }
  return text;
}

std::string off(const Mesh& mesh) {
  std::string text = "OFF # made by hand\n\n" + std::to_string(mesh.vertices.size()) + " " +
                     std::to_string(mesh.faces.size()) + " 0\n";
  for (const Vec3& p : mesh.vertices) text += numbers(p) + "\n";
  for (const auto& face : mesh.faces) {
    text += std::to_string(face.size());
    for (const int corner : face) text += " " + std::to_string(corner);
    text += " 255 0 0\n";
  }
  return text;
}

std::string ply(const Mesh& mesh, const std::string& format, const std::string& comment = "") {
  const bool is_binary = format != "ascii", is_turned = format == "binary_big_endian";
  std::string text =
      "ply\nformat " + format + " 1.0\n" + comment + "element vertex " +
      std::to_string(mesh.vertices.size()) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nelement face " +
      std::to_string(mesh.faces.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    if (!is_binary) {
      text += std::to_string(value) + " ";
      return;
    }
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (is_turned) std::reverse(bytes.begin(), bytes.end());
    text += bytes;
  };
  for (const Vec3& p : mesh.vertices) {
    for (int i = 0; i < 3; ++i) put(p[i]);
    put(uint8_t{7});
  }
  for (const auto& face : mesh.faces) {
    put(static_cast<uint8_t>(face.size()));
    for (const int corner : face) put(int32_t{corner});
  }
  return text;
}

Solid solid_of(const std::string& text, const std::string& ending, const ReadSolidOptions& options = {}) {
  Result<Solid> solid = read_text(text, ending, options);
  if (!solid) {
    ADD_FAILURE() << solid.error().message;
    return {};
  }
  return std::move(solid).value();
}

TEST(Mesh, ABoxIsTheSameInEveryFormat) {
  const Mesh mesh = box();
  for (const auto& [text, ending] :
       std::vector<std::pair<std::string, std::string>>{{binary_stl(mesh), ".stl"},
                                                        {ascii_stl(mesh), ".STL"},
                                                        {obj(mesh), ".obj"},
                                                        {off(mesh), ".off"},
                                                        {ply(mesh, "ascii"), ".ply"},
                                                        {ply(mesh, "binary_little_endian"), ".ply"},
                                                        {ply(mesh, "binary_big_endian"), ".ply"}}) {
    const Solid solid = solid_of(text, ending);
    EXPECT_NEAR(solid.volume_mm3, 6000, 1e-9) << ending;
    EXPECT_NEAR(solid.area_mm2, 2200, 1e-9) << ending;
    EXPECT_LT((solid.centroid_mm - Vec3(5, 10, 15)).norm(), 1e-12) << ending;
    EXPECT_TRUE(solid.warnings.empty()) << solid.warnings.front();
    ASSERT_EQ(solid.faces().size(), 6u) << ending;
    for (const Face& face : solid.faces()) {
      EXPECT_EQ(face.type, SurfaceType::plane);
      EXPECT_EQ(face.neighbours.size(), 4u);
      EXPECT_EQ(face.surface, face.id);
      EXPECT_NEAR(face.normal.dot(face.point_mm), face.d_mm, 1e-12);
      EXPECT_GT(face.normal.dot(face.point_mm - solid.centroid_mm), 0);
    }
    // As the same box from .csg, in the same order.
    EXPECT_TRUE(solid.faces()[0].normal.isApprox(Vec3(-1, 0, 0)));
    EXPECT_TRUE(solid.faces()[5].normal.isApprox(Vec3(1, 0, 0)));
  }
}

TEST(Mesh, UnitsScaleAndADeclaredOneWins) {
  ReadSolidOptions inch;
  inch.unit_scale_mm = 25.4;
  EXPECT_NEAR(solid_of(binary_stl(box()), ".stl", inch).volume_mm3, 6000 * std::pow(25.4, 3), 1e-3);
  const Solid declared = solid_of(ply(box(), "ascii", "comment unit cm\n"), ".ply", inch);
  EXPECT_NEAR(declared.volume_mm3, 6e6, 1e-3);
  EXPECT_EQ(declared.declared_unit, "cm");
  const Solid small = solid_of(binary_stl(box(Vec3(0.1, 0.2, 0.3))), ".stl");
  ASSERT_EQ(small.warnings.size(), 1u);
  EXPECT_NE(small.warnings[0].find("--unit"), std::string::npos);
  EXPECT_NE(error_of(ply(box(), "ascii", "comment unit furlong\n"), ".ply").find("furlong"),
            std::string::npos);
}

TEST(Mesh, AStaircaseHasFifteenFacesOnFourteenSurfaces) {
  const std::vector<std::pair<double, double>> outline{{0, 0},   {80, 0},  {80, 20}, {60, 20}, {60, 40},
                                                       {40, 40}, {40, 50}, {20, 50}, {20, 60}, {0, 60},
                                                       {0, 40},  {30, 10}, {0, 10}};
  Mesh mesh;
  std::vector<int> front, back;
  const int n = static_cast<int>(outline.size());
  // Turned about an odd axis, so that no coordinate is round.
  const Mat3 R = rotation_from_degrees(13, -27, 51);
  for (const double y : {0.0, 60.0}) {
    for (const auto& [x, z] : outline) mesh.vertices.push_back(R * Vec3(x, y, z) + Vec3(100, 200, -300));
  }
  for (int k = 0; k < n; ++k) {
    mesh.faces.push_back({k, n + k, n + (k + 1) % n, (k + 1) % n});
    front.push_back(k);
    back.push_back(2 * n - 1 - k);
  }
  mesh.faces.push_back(front);
  mesh.faces.push_back(back);
  for (const std::string ending : {".obj", ".off"}) {
    const Solid solid = solid_of(ending == ".obj" ? obj(mesh) : off(mesh), ending);
    EXPECT_EQ(solid.faces().size(), 15u);
    int surfaces = 0;
    for (const Face& face : solid.faces()) surfaces = std::max(surfaces, face.surface);
    EXPECT_EQ(surfaces, 14);
    EXPECT_NEAR(solid.volume_mm3, 2950 * 60, 0.1);  // the file has six decimals
    EXPECT_EQ(count(solid, SurfaceType::plane), 15);
  }
}

TEST(Mesh, ManyFacetsOfARoundBodyAreOneFaceAndFewAreNot) {
  for (const int sides : {13, 24, 48, 200}) {
    const Solid solid = solid_of(obj(cylinder(8, 25, sides)), ".obj");
    EXPECT_EQ(solid.faces().size(), 3u) << sides;
    EXPECT_EQ(count(solid, SurfaceType::plane), 2) << sides;
    ReadSolidOptions facets;
    facets.keep_facets = true;
    EXPECT_EQ(count(solid_of(obj(cylinder(8, 25, sides)), ".obj", facets), SurfaceType::plane), sides + 2);
  }
  for (const int sides : {3, 6, 8, 12}) {
    EXPECT_EQ(count(solid_of(obj(cylinder(8, 25, sides)), ".obj"), SurfaceType::plane), sides + 2);
  }
}

TEST(Mesh, PlanesRunningOutIntoFilletsStayPlanes) {
  // A bar with two flats and two half-round sides of 12 facets each.
  for (const double flat : {3.0, 20.0, 100.0}) {
    Mesh mesh;
    std::vector<int> bottom, top;
    const int half = 12, n = 2 * (half + 1);
    for (const double z : {0.0, 30.0}) {
      for (int k = 0; k < n; ++k) {
        const bool is_left = k > half;
        const double phi = std::numbers::pi * ((is_left ? k - 1 : k) / static_cast<double>(half) - 0.5);
        mesh.vertices.emplace_back((is_left ? -flat : flat) / 2 + 5 * std::cos(phi), 5 * std::sin(phi), z);
      }
    }
    for (int k = 0; k < n; ++k) {
      mesh.faces.push_back({k, (k + 1) % n, n + (k + 1) % n, n + k});
      bottom.push_back(n - 1 - k);
      top.push_back(n + k);
    }
    mesh.faces.push_back(bottom);
    mesh.faces.push_back(top);
    const Solid solid = solid_of(obj(mesh), ".obj");
    EXPECT_EQ(count(solid, SurfaceType::plane), 4) << flat;
    EXPECT_EQ(count(solid, SurfaceType::other), 2) << flat;
  }
}

TEST(Mesh, ConcavePolygonsAndCavitiesAndSeveralBodies) {
  // An L of six corners, whose fan from the first corner would leave it.
  const std::string l =
      "v 2 1 0\nv 2 4 0\nv 0 4 0\nv 0 0 0\nv 6 0 0\nv 6 1 0\nv 2 1 3\nv 2 4 3\nv 0 4 3\nv 0 0 3\nv 6 0 3\nv "
      "6 1 3\n"
      "f 6 5 4 3 2 1\nf -6 -5 -4 -3 -2 -1\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 "
      "7 12\n";
  const Solid bracket = solid_of(l, ".obj");
  EXPECT_NEAR(bracket.volume_mm3, 3 * (8 + 4), 1e-12);
  EXPECT_NEAR(bracket.area_mm2, 2 * 12 + 3 * 20, 1e-12);
  EXPECT_EQ(bracket.faces().size(), 8u);

  Mesh two = box(Vec3(10, 10, 10));
  const auto add = [&](const Vec3& at, double size, bool is_inward) {
    Mesh other = box(Vec3(size, size, size));
    for (auto& face : other.faces) {
      for (int& corner : face) corner += static_cast<int>(two.vertices.size());
      if (is_inward) std::reverse(face.begin(), face.end());
    }
    for (const Vec3& p : other.vertices) two.vertices.push_back(p + at);
    two.faces.insert(two.faces.end(), other.faces.begin(), other.faces.end());
  };
  add(Vec3(3, 3, 3), 2, true);
  const Solid hollow = solid_of(off(two), ".off");
  EXPECT_NEAR(hollow.volume_mm3, 992, 1e-9);
  EXPECT_EQ(hollow.solids, 1);
  EXPECT_FALSE(RayCaster(hollow).inside(Vec3(4, 4, 4)));
  add(Vec3(20, 0, 0), 3, true);  // inside out, and nothing around it
  const Solid both = solid_of(off(two), ".off");
  EXPECT_NEAR(both.volume_mm3, 992 + 27, 1e-9);
  EXPECT_EQ(both.solids, 2);
  ASSERT_EQ(both.warnings.size(), 1u);
  EXPECT_NE(both.warnings[0].find("inside out"), std::string::npos);
}

TEST(Mesh, TrianglesTheWrongWayRoundAreTurnedWithAWarning) {
  Mesh mesh = box();
  for (auto& face : mesh.faces) std::reverse(face.begin(), face.end());
  const Solid inverted = solid_of(obj(mesh), ".obj");
  EXPECT_NEAR(inverted.volume_mm3, 6000, 1e-9);
  ASSERT_EQ(inverted.warnings.size(), 1u);
  mesh = box();
  std::reverse(mesh.faces[1].begin(), mesh.faces[1].end());
  const Solid mixed = solid_of(obj(mesh), ".obj");
  EXPECT_NEAR(mixed.volume_mm3, 6000, 1e-9);
  ASSERT_EQ(mixed.warnings.size(), 1u);
  EXPECT_NE(mixed.warnings[0].find("2 of 12"), std::string::npos) << mixed.warnings[0];
}

TEST(Mesh, CornersAFewDigitsApartAreOneAndGapsAreNamed) {
  Mesh mesh = box();
  mesh.vertices.push_back(mesh.vertices[0] + Vec3(1e-5, 0, -1e-5));
  mesh.faces[0][0] = 8;
  EXPECT_TRUE(solid_of(off(mesh), ".off").warnings.empty());
  mesh.vertices[8] = mesh.vertices[0] + Vec3(1e-3, 0, 0);
  const Solid gaping = solid_of(off(mesh), ".off");
  ASSERT_EQ(gaping.warnings.size(), 1u);
  EXPECT_NE(gaping.warnings[0].find("gaps"), std::string::npos);
  EXPECT_NEAR(gaping.volume_mm3, 6000, 1);
  mesh.vertices[8] = mesh.vertices[0] + Vec3(0.1, 0, 0);
  EXPECT_NE(error_of(off(mesh), ".off").find("open at"), std::string::npos);
  mesh = box();
  mesh.faces.pop_back();
  const std::string open = error_of(off(mesh), ".off");
  EXPECT_NE(open.find("open at 4 edges"), std::string::npos) << open;
  EXPECT_NE(open.find("(10, 0, 0) mm"), std::string::npos) << open;
}

TEST(Mesh, WallsBackToBackVanish) {
  // Two boxes that share a whole face, each with its own triangles of it.
  Mesh mesh = box(Vec3(10, 10, 10));
  Mesh other = box(Vec3(10, 10, 10));
  std::reverse(other.faces[4].begin(), other.faces[4].end());
  std::rotate(other.faces[4].begin(), other.faces[4].begin() + 1, other.faces[4].end());
  std::reverse(other.faces[4].begin(), other.faces[4].end());
  for (auto& face : other.faces) {
    for (int& corner : face) corner += 8;
  }
  for (const Vec3& p : other.vertices) mesh.vertices.push_back(p + Vec3(10, 0, 0));
  mesh.faces.insert(mesh.faces.end(), other.faces.begin(), other.faces.end());
  const Solid solid = solid_of(off(mesh), ".off");
  EXPECT_NEAR(solid.volume_mm3, 2000, 1e-9);
}

TEST(Mesh, DamagedFilesNameThePlace) {
  const auto names = [](const std::string& text, const std::string& ending, const std::string& part) {
    const std::string error = error_of(text, ending);
    EXPECT_NE(error.find(part), std::string::npos) << ending << ": " << error;
  };
  const std::string stl = binary_stl(box());
  for (size_t size : {size_t{0}, size_t{50}, size_t{84}, stl.size() - 1, stl.size() - 50}) {
    EXPECT_NE(error_of(stl.substr(0, size), ".stl"), "") << size;
  }
  std::string nan = stl;
  const float not_a_number = std::nanf("");
  std::memcpy(nan.data() + 84 + 50 * 3 + 16, &not_a_number, 4);
  names(nan, ".stl", "triangle 4 has a corner that is no number");
  names("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 q\n", ".stl",
        ".stl:4: 'q' stands where a number");
  names("solid x\n", ".stl", "the file ends where 'endsolid'");
  names(ascii_stl(box()).substr(0, 300), ".stl", "the file ends");
  names("solid x\nendsolid x\n", ".stl", "no triangles");
  names("v 0 0 0\nv 1 0\n", ".obj", ".obj:2: a vertex needs three numbers");
  names("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", ".obj", ".obj:4: a face names vertex 3");
  names("v 0 0 0\nv 1 0 nan\n", ".obj", "three numbers");
  names("v 0 0 0\ncurv2 1 2\n", ".obj", "'curv2' is not supported");
  names("hello\n", ".off", "does not begin with 'OFF'");
  names("OFF\n99999999999 1 0\n", ".off", "more vertices or faces than the file can hold");
  names("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", ".off", "face 0 needs");
  names(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n0 0 0\n",
      ".ply", "no element 'face'");
  const std::string whole = ply(box(), "binary_little_endian");
  names(whole.substr(0, whole.size() - 3), ".ply", "face 5");
  names(whole + "0123", ".ply", "4 bytes follow");
  names(off(box()) + "3 0 1 2\n", ".off", "'3' follows after all");
  names("v 0 0 0\n\x1b[2J\xff\n", ".obj", ".obj:2: '?[2J?' is not supported");
  Mesh tiny = box(Vec3(10, 10, 10));
  for (Vec3& p : tiny.vertices) p *= 1e-320;
  names(off(tiny), ".off", "size makes no sense");
  Mesh flat = box(Vec3(10, 10, 10));
  for (Vec3& p : flat.vertices) p.z() = 0;
  EXPECT_NE(error_of(off(flat), ".off"), "");
}

struct CadMesh {
  const char* file;
  double unit_mm;
  int planes;           // of more than 20 mm2: flat faces of the part, counted by hand; -1: not known
  double volume, area;  // file units; of the triangles, computed apart from this program
};

// A few facets at the ends of round faces stay planes of their own: small ones.
constexpr double kSmallFace_mm2 = 20;

const std::vector<CadMesh>& cad_meshes() {
  static const std::vector<CadMesh> kMeshes{{"angle_block.STL", 25.4, -1, 1.1455, 9.3873},
                                            {"featuretype.STL", 25.4, -1, 11.6277, 53.8274},
                                            {"idler_riser.STL", 25.4, 13, 1.4878, 18.1355},
                                            {"octagonal_pocket.stl", 1000, -1, 0.0003, 0.0748},
                                            {"plate_holes.STL", 1, 7, 767362.1126, 133343.4119}};
  return kMeshes;
}

TEST(Mesh, CadExportsOfOthers) {
  const std::filesystem::path folder = std::filesystem::path(TETRAGAUGE_SHARED_DATA) / "mesh_cad/trimesh";
  if (!std::filesystem::exists(folder))
    GTEST_SKIP() << folder << " is not here; the folder shared is optional";
  for (const CadMesh& known : cad_meshes()) {
    ReadSolidOptions options;
    options.unit_scale_mm = known.unit_mm;
    Result<Solid> solid = read_solid(folder / known.file, options);
    ASSERT_TRUE(solid) << solid.error().message;
    EXPECT_TRUE(solid->warnings.empty()) << solid->warnings[0];
    EXPECT_EQ(solid->solids, 1);
    EXPECT_NEAR(solid->volume_mm3, known.volume * std::pow(known.unit_mm, 3),
                6e-5 * std::pow(known.unit_mm, 3));
    EXPECT_NEAR(solid->area_mm2, known.area * std::pow(known.unit_mm, 2), 6e-5 * std::pow(known.unit_mm, 2));
    const auto planes = std::count_if(solid->faces().begin(), solid->faces().end(), [](const Face& face) {
      return face.type == SurfaceType::plane && face.area_mm2 > kSmallFace_mm2;
    });
    if (known.planes >= 0) {
      EXPECT_EQ(planes, known.planes) << known.file;
    }
    for (size_t i = 0; i < solid->triangles.size(); ++i) {
      const Face& face = solid->faces()[solid->triangle_face[i]];
      if (face.type != SurfaceType::plane) continue;
      for (const uint32_t v : solid->triangles[i]) {
        ASSERT_NEAR(distance_to_surface(face, solid->vertices[v]), 0, 1e-3)
            << known.file << " face " << face.id;
      }
    }
  }
}

TEST(Mesh, AnExportHasThePlanesOfItsStepFile) {
  const std::filesystem::path shared(TETRAGAUGE_SHARED_DATA);
  if (!std::filesystem::exists(shared))
    GTEST_SKIP() << shared << " is not here; the folder shared is optional";
  ReadSolidOptions inch;
  inch.unit_scale_mm = 25.4;
  Result<Solid> mesh = read_solid(shared / "mesh_cad/trimesh/featuretype.STL", inch);
  Result<Solid> step = read_solid(shared / "step/trimesh/featuretype.STEP");
  ASSERT_TRUE(mesh && step);
  for (const Face& face : step->faces()) {
    if (face.type != SurfaceType::plane) continue;
    const auto same = [&](const Face& other) {
      return other.type == SurfaceType::plane && face.normal.dot(other.normal) > 1 - 1e-9 &&
             std::abs(face.d_mm - other.d_mm) < 1e-3 && (face.point_mm - other.point_mm).norm() < 0.5 &&
             std::abs(face.area_mm2 - other.area_mm2) < 0.02 * face.area_mm2 + 0.5;
    };
    EXPECT_EQ(std::count_if(mesh->faces().begin(), mesh->faces().end(), same), 1) << "face " << face.id;
  }
  EXPECT_NEAR(mesh->volume_mm3, step->volume_mm3, 1e-3 * step->volume_mm3);
}

}  // namespace
}  // namespace tetragauge
