// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/mesh_file.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace tetragauge {
namespace {

// Of the bytes of `values` behind their count, as VTK's inline binary wants it.
template <class T>
std::string base64_block(const std::vector<T>& values) {
  static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const uint64_t size = values.size() * sizeof(T);
  std::string bytes(sizeof size + size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, values.data(), size);
  std::string text;
  text.reserve(bytes.size() / 3 * 4 + 4);
  for (size_t at = 0; at < bytes.size(); at += 3) {
    const size_t have = std::min<size_t>(3, bytes.size() - at);
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < have ? static_cast<uint8_t>(bytes[at + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += k <= have ? kLetters[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <class T>
std::string data_array(const char* type, const char* name, int components, const std::vector<T>& values) {
  return std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(components) + "\" format=\"binary\">" + base64_block(values) + "</DataArray>\n";
}

}  // namespace

std::string surface_to_ply(const Reconstruction& reconstruction) {
  std::string ply = "ply\nformat binary_little_endian 1.0\ncomment unit mm\ncomment frame part\n";
  ply += "element vertex " + std::to_string(reconstruction.vertices.size()) + "\n";
  for (const char* name : {"x", "y", "z"}) ply += std::string("property double ") + name + "\n";
  ply += "element face " + std::to_string(reconstruction.surface.size()) + "\n";
  ply +=
      "property list uchar uint vertex_indices\nproperty float confidence\nproperty uchar "
      "unseen\nend_header\n";
  const auto put = [&](const auto& value) {
    ply.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const Vec3& vertex : reconstruction.vertices) {
    for (int k = 0; k < 3; ++k) put(vertex[k]);
  }
  for (const SurfaceTriangle& triangle : reconstruction.surface) {
    put(uint8_t{3});
    for (const uint32_t vertex : triangle.vertex) put(vertex);
    put(triangle.confidence);
    put(static_cast<uint8_t>(triangle.unseen));
  }
  return ply;
}

std::string surface_to_stl(const Reconstruction& reconstruction) {
  std::string stl = "tetragauge surface, mm, part frame";
  stl.resize(80, ' ');
  const auto put = [&](const auto& value) {
    stl.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const auto put_vector = [&](const Vec3& v) {
    for (int k = 0; k < 3; ++k) put(static_cast<float>(v[k]));
  };
  put(static_cast<uint32_t>(reconstruction.surface.size()));
  for (const SurfaceTriangle& triangle : reconstruction.surface) {
    const Vec3& a = reconstruction.vertices[triangle.vertex[0]];
    const Vec3 normal = (reconstruction.vertices[triangle.vertex[1]] - a)
                            .cross(reconstruction.vertices[triangle.vertex[2]] - a);
    put_vector(normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3(Vec3::Zero()));
    for (const uint32_t vertex : triangle.vertex) put_vector(reconstruction.vertices[vertex]);
    put(uint16_t{0});
  }
  return stl;
}

std::string tetrahedra_to_vtu(const Reconstruction& reconstruction) {
  constexpr uint8_t kVtkTetra = 10;
  const size_t cells = reconstruction.cells.size();
  std::vector<double> points;
  for (const Vec3& p : reconstruction.vertices) points.insert(points.end(), {p.x(), p.y(), p.z()});
  std::vector<int64_t> connectivity, offsets;
  std::vector<uint8_t> types(cells, kVtkTetra), label, doubtful;
  std::vector<float> confidence, air_rays, solid_rays;
  for (const LabelledTetrahedron& cell : reconstruction.cells) {
    connectivity.insert(connectivity.end(), cell.vertex.begin(), cell.vertex.end());
    offsets.push_back(static_cast<int64_t>(connectivity.size()));
    label.push_back(cell.is_air ? 0 : 1);
    doubtful.push_back(cell.is_doubtful ? 1 : 0);
    confidence.push_back(cell.confidence);
    air_rays.push_back(cell.air_rays);
    solid_rays.push_back(cell.solid_rays);
  }
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
         "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
         std::to_string(reconstruction.vertices.size()) + "\" NumberOfCells=\"" + std::to_string(cells) +
         "\">\n<Points>\n" + data_array("Float64", "Points", 3, points) + "</Points>\n<Cells>\n" +
         data_array("Int64", "connectivity", 1, connectivity) + data_array("Int64", "offsets", 1, offsets) +
         data_array("UInt8", "types", 1, types) + "</Cells>\n<CellData Scalars=\"label\">\n" +
         data_array("UInt8", "label", 1, label) + data_array("UInt8", "doubtful", 1, doubtful) +
         data_array("Float32", "confidence", 1, confidence) + data_array("Float32", "air_rays", 1, air_rays) +
         data_array("Float32", "solid_rays", 1, solid_rays) +
         "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace tetragauge
