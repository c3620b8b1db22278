// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "host/base/excerpt.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/geometry/ply_elements.hpp"
#include "host/solid/cut_polygon.hpp"
#include "host/solid/parse_mesh.hpp"

namespace tetragauge {
namespace {

// One row of an element: its plain properties in order, and the one list that is asked for.
struct Row {
  std::vector<double> values;  // by property; 0 for lists
  std::vector<double> list;
};

constexpr size_t kNone = static_cast<size_t>(-1);

size_t find_property(const PlyElement& element, std::string_view name, bool is_list) {
  for (size_t k = 0; k < element.properties.size(); ++k) {
    const PlyProperty& property = element.properties[k];
    if (property.name == name && property.count_type.has_value() == is_list) return k;
  }
  return kNone;
}

bool read_row(const PlyElement& element, size_t list_property, PlyBody& body, Row& row) {
  row.values.assign(element.properties.size(), 0);
  row.list.clear();
  for (size_t k = 0; k < element.properties.size(); ++k) {
    const PlyProperty& property = element.properties[k];
    double value = 0;
    if (!body.next(property.count_type.value_or(property.type), value)) return false;
    if (!property.count_type) {
      row.values[k] = value;
      continue;
    }
    if (!(value >= 0)) return false;
    for (double i = 0; i < value; ++i) {
      double item = 0;
      if (!body.next(property.type, item)) return false;
      if (k == list_property) row.list.push_back(item);
    }
  }
  return true;
}

std::string unit_comment(const PlyHeader& header) {
  for (const PlyComment& comment : header.comments) {
    std::string_view text = comment.text;
    if (next_word(text) == "unit") return std::string(next_word(text));
  }
  return "";
}

}  // namespace

Result<TriangleMesh> parse_ply_mesh(std::string_view content, const std::string& file) {
  Result<PlyHeader> header = read_ply_header(content, file);
  if (!header) return header.error();
  TriangleMesh mesh;
  mesh.declared_unit = unit_comment(*header);
  PlyBody body(content, header->format);
  Row row;
  std::vector<int64_t> corners;
  bool has_faces = false;
  for (const PlyElement& element : header->elements) {
    if (Status status = check_ply_count(element, body, file); !status) return status.error();
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    has_faces |= is_face;
    const std::array<size_t, 3> place{find_property(element, "x", false), find_property(element, "y", false),
                                      find_property(element, "z", false)};
    size_t list = find_property(element, "vertex_indices", true);
    if (list == kNone) list = find_property(element, "vertex_index", true);
    if (is_vertex && std::count(place.begin(), place.end(), kNone) > 0) {
      return bad_input(file + ": element 'vertex' has no x, y and z; export it again");
    }
    if (is_face && list == kNone) {
      return bad_input(file +
                       ": element 'face' has no list vertex_indices; export it with triangles or polygons");
    }
    for (uint64_t i = 0; i < element.count; ++i) {
      const std::string where = file + ": " + excerpt(element.name) + " " + std::to_string(i) + ": ";
      if (!read_row(element, list, body, row)) {
        return bad_input(where + "not a number, or the file ends within it; it is cut short or damaged");
      }
      if (is_vertex) {
        const Vec3 p(row.values[place[0]], row.values[place[1]], row.values[place[2]]);
        if (!p.allFinite()) return bad_input(where + "a coordinate is no number; export it again");
        mesh.vertices.push_back(p);
      } else if (is_face) {
        corners.clear();
        for (const double index : row.list) {
          const bool is_index = index >= 0 && index < 4294967296.0 && index == std::floor(index);
          corners.push_back(is_index ? static_cast<int64_t>(index) : -1);
        }
        if (Status status = add_polygon(corners, where, mesh); !status) return status.error();
      }
    }
  }
  if (Status status = check_ply_end(body, file); !status) return status.error();
  if (!has_faces) {
    return bad_input(file +
                     ": no element 'face': points, not a solid; a scan goes where the command asks for one");
  }
  return mesh;
}

}  // namespace tetragauge
