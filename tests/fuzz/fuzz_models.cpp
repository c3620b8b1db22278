// SPDX-License-Identifier: GPL-3.0-or-later
// Fuzzes what reads models that others wrote, up to the faces of a mesh and the tree of a .csg file;
// OpenCASCADE is not in it. The first byte chooses the format: 0 STL, 1 OBJ, 2 OFF, 3 PLY, 4 .csg.
#include <cmath>

#include "host/solid/close_mesh.hpp"
#include "host/solid/group_facets.hpp"
#include "host/solid/parse_csg.hpp"
#include "host/solid/parse_mesh.hpp"
#include "tests/fuzz/check_error.hpp"

using namespace tetragauge;
using fuzz::must;

namespace {

const std::string kFile = "fuzzed-model";

void check_mesh(const Result<TriangleMesh>& mesh) {
  if (!mesh) return fuzz::check_error(mesh.error(), kFile);
  for (const auto& t : mesh->triangles) {
    for (const uint32_t v : t) must(v < mesh->vertices.size(), "a triangle names vertices that are there");
  }
  for (const Vec3& p : mesh->vertices) must(p.allFinite(), "coordinates are numbers");
  const Result<ClosedMesh> closed = close_mesh(*mesh, kFile);
  if (!closed) return fuzz::check_error(closed.error(), kFile);
  must(closed->bodies > 0, "a closed mesh has a body");
  for (const bool curved : {false, true}) {
    size_t grouped = 0;
    for (const FacetGroup& group : group_facets(*closed, curved).groups) {
      grouped += group.triangles.size();
      if (!group.is_plane) continue;
      must(std::abs(group.normal.norm() - 1) < 1e-9 && std::isfinite(group.d_mm), "planes are numbers");
    }
    must(grouped == closed->triangles.size(), "each triangle is in one group");
  }
}

void check_csg(std::string_view text) {
  const Result<std::vector<CsgNode>> nodes = parse_csg(text, kFile);
  if (!nodes) fuzz::check_error(nodes.error(), kFile);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  constexpr Result<TriangleMesh> (*kParsers[])(std::string_view, const std::string&) = {
      parse_stl, parse_obj, parse_off, parse_ply_mesh};
  const size_t format = data[0] % 5;
  format < 4 ? check_mesh(kParsers[format](text, kFile)) : check_csg(text);
  return 0;
}
