// SPDX-License-Identifier: GPL-3.0-or-later
// Fuzzes what reads models that others wrote, up to the faces of a mesh and the arguments of each call of a
// .csg file; of OpenCASCADE only its matrices are in it. The first byte chooses the format: 0 STL, 1 OBJ, 2
// OFF, 3 PLY, 4 .csg.
#include <algorithm>
#include <cmath>

#include "host/solid/close_mesh.hpp"
#include "host/solid/csg_arguments.hpp"
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

bool are_numbers(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

// Every argument read as everything that a call may ask for.
void check_arguments(CsgNode node) {
  const auto attempt = [&](const auto& read) {
    try {
      read();
    } catch (const CsgFailure& failure) {
      must(failure.line == node.line, "errors name the line of the call");
      // As host/solid/read_solid.cpp says it.
      fuzz::check_error(bad_input(kFile + ":" + std::to_string(failure.line) + ": " + failure.what()), kFile);
    }
  };
  for (const auto& [key, value] : node.arguments) {
    const std::string name = key;
    attempt([&] { must(std::isfinite(number_argument(node, name, 1)), "numbers are numbers"); });
    attempt([&] { must(positive_argument(node, name) > 0, "what must be above 0 is"); });
    attempt([&] { bool_argument(node, name, true); });
    for (const size_t size : {2u, 3u}) {
      attempt([&] {
        const std::vector<double> read = vector_argument(node, name, size);
        must(read.size() == size && are_numbers(read), "vectors are of their size");
      });
      attempt([&] {
        for (const std::vector<double>& row : rows_argument(node, name, size))
          must(row.size() == size && are_numbers(row), "rows are of their width");
      });
    }
    attempt([&] {
      for (const std::vector<size_t>& loop : index_lists_argument(node, name, 5)) {
        for (const size_t index : loop) must(index < 5, "indices are within");
      }
    });
  }
  attempt([&] {
    const Affine M = matrix_argument(node);
    must(M.A.allFinite() && M.t.allFinite(), "matrices are numbers");
    similarity(M);
    axial_scale(M);
  });
  for (const bool keep_facets : {false, true}) {
    node.keep_facets = keep_facets;
    attempt([&] {
      const size_t sides = facets(node, 10);
      must(sides == 0 || (sides >= 3 && sides <= 1000000), "a turn has its facets");
    });
  }
  for (const CsgNode& child : node.children) check_arguments(child);
}

void check_csg(std::string_view text) {
  const Result<std::vector<CsgNode>> nodes = parse_csg(text, kFile);
  if (!nodes) return fuzz::check_error(nodes.error(), kFile);
  for (const CsgNode& node : *nodes) check_arguments(node);
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
