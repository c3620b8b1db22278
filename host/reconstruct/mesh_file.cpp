// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/mesh_file.hpp"

namespace tetragauge {

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

}  // namespace tetragauge
