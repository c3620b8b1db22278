// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/polyhedral_solid.hpp"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRep_Builder.hxx>
#include <Geom_Plane.hxx>
#include <Precision.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <gp_Pln.hxx>
#include <map>
#include <numeric>
#include <string>

namespace tetragauge {
namespace {

// OpenSCAD prints six digits: corners of a plane face may lie this share of the part's size off its plane.
constexpr double kSixDigits = 2e-6;

std::string text(const Vec3& p) {
  const auto number = [](double x) {
    std::string digits = std::to_string(x);
    return digits;
  };
  return "(" + number(p.x()) + ", " + number(p.y()) + ", " + number(p.z()) + ")";
}

// Equal corners become one; loops lose repeated corners, faces with fewer than three corners vanish.
void weld_corners(PolyhedralMesh& mesh) {
  std::vector<size_t> order(mesh.corners.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto less = [&](size_t a, size_t b) {
    const Vec3 &p = mesh.corners[a], &q = mesh.corners[b];
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  };
  std::stable_sort(order.begin(), order.end(), less);
  std::vector<size_t> representative(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const bool is_equal = k > 0 && mesh.corners[order[k]] == mesh.corners[order[k - 1]];
    representative[order[k]] = is_equal ? representative[order[k - 1]] : order[k];
  }
  const auto weld = [&](CornerLoop& loop) {
    for (size_t& corner : loop) corner = representative[corner];
    loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
  };
  for (PolyhedralFace& face : mesh.faces) {
    weld(face.outer);
    for (CornerLoop& hole : face.holes) weld(hole);
  }
  std::erase_if(mesh.faces, [](const PolyhedralFace& face) { return face.outer.size() < 3; });
}

// Twice the vector area (Newell), about `origin`.
Vec3 double_area(const PolyhedralMesh& mesh, const CornerLoop& loop, const Vec3& origin) {
  Vec3 sum = Vec3::Zero();
  for (size_t i = 0; i < loop.size(); ++i) {
    const Vec3& p = mesh.corners[loop[i]];
    const Vec3& q = mesh.corners[loop[(i + 1) % loop.size()]];
    sum += (p - origin).cross(q - origin);
  }
  return sum;
}

double signed_volume(const PolyhedralMesh& mesh, const std::vector<size_t>& surface, const Vec3& origin) {
  double volume = 0;
  const auto add = [&](const CornerLoop& loop) {
    volume += (mesh.corners[loop[0]] - origin).dot(double_area(mesh, loop, mesh.corners[loop[0]])) / 6;
  };
  for (const size_t face : surface) {
    add(mesh.faces[face].outer);
    for (const CornerLoop& hole : mesh.faces[face].holes) add(hole);
  }
  return volume;
}

void turn_inside_out(PolyhedralMesh& mesh) {
  for (PolyhedralFace& face : mesh.faces) {
    std::reverse(face.outer.begin(), face.outer.end());
    for (CornerLoop& hole : face.holes) std::reverse(hole.begin(), hole.end());
  }
}

// Each edge must be run once each way; otherwise the surface is open or its faces run both ways round.
void check_closed(const PolyhedralMesh& mesh) {
  std::map<std::pair<size_t, size_t>, int> uses;
  const auto add = [&](const CornerLoop& loop) {
    for (size_t i = 0; i < loop.size(); ++i) ++uses[{loop[i], loop[(i + 1) % loop.size()]}];
  };
  for (const PolyhedralFace& face : mesh.faces) {
    add(face.outer);
    for (const CornerLoop& hole : face.holes) add(hole);
  }
  for (const auto& [edge, count] : uses) {
    const auto back = uses.find({edge.second, edge.first});
    if (count == 1 && back != uses.end() && back->second == 1) continue;
    throw PolyhedronFailure("the surface is open, or its faces run both ways round, at the edge from " +
                            text(mesh.corners[edge.first]) + " to " + text(mesh.corners[edge.second]) +
                            "; close it and give all faces the same sense");
  }
}

// Faces that hang together by edges, in order of their first face.
std::vector<std::vector<size_t>> connected_surfaces(const PolyhedralMesh& mesh) {
  std::vector<size_t> parent(mesh.faces.size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  const auto root = [&](size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::map<std::pair<size_t, size_t>, size_t> face_of_edge;
  const auto join = [&](const CornerLoop& loop, size_t face) {
    for (size_t i = 0; i < loop.size(); ++i) {
      const std::pair<size_t, size_t> edge = std::minmax(loop[i], loop[(i + 1) % loop.size()]);
      const size_t other = face_of_edge.emplace(edge, face).first->second;
      const size_t a = root(face), b = root(other);
      parent[std::max(a, b)] = std::min(a, b);
    }
  };
  for (size_t i = 0; i < mesh.faces.size(); ++i) {
    join(mesh.faces[i].outer, i);
    for (const CornerLoop& hole : mesh.faces[i].holes) join(hole, i);
  }
  std::vector<std::vector<size_t>> surfaces;
  std::map<size_t, size_t> surface_of_root;
  for (size_t i = 0; i < mesh.faces.size(); ++i) {
    const auto [found, is_new] = surface_of_root.emplace(root(i), surfaces.size());
    if (is_new) surfaces.emplace_back();
    surfaces[found->second].push_back(i);
  }
  return surfaces;
}

class Builder {
 public:
  explicit Builder(const PolyhedralMesh& mesh, double tolerance_mm)
      : mesh_(mesh), tolerance_mm_(tolerance_mm), vertices_(mesh.corners.size()) {}

  TopoDS_Solid solid(const std::vector<std::vector<size_t>>& surfaces) {
    TopoDS_Solid solid;
    builder_.MakeSolid(solid);
    for (const std::vector<size_t>& surface : surfaces) {
      TopoDS_Shell shell;
      builder_.MakeShell(shell);
      for (const size_t i : surface) builder_.Add(shell, face(i));
      shell.Closed(true);
      builder_.Add(solid, shell);
    }
    return solid;
  }

 private:
  const TopoDS_Vertex& vertex(size_t corner) {
    TopoDS_Vertex& vertex = vertices_[corner];
    if (vertex.IsNull()) {
      const Vec3& p = mesh_.corners[corner];
      builder_.MakeVertex(vertex, gp_Pnt(p.x(), p.y(), p.z()), Precision::Confusion());
    }
    return vertex;
  }

  TopoDS_Edge edge(size_t from, size_t to) {
    const std::pair<size_t, size_t> key = std::minmax(from, to);
    auto found = edges_.find(key);
    if (found == edges_.end()) {
      BRepBuilderAPI_MakeEdge make(vertex(key.first), vertex(key.second));
      if (!make.IsDone()) {
        throw PolyhedronFailure("the edge from " + text(mesh_.corners[from]) + " to " +
                                text(mesh_.corners[to]) + " is too short; merge its ends");
      }
      found = edges_.emplace(key, make.Edge()).first;
    }
    return TopoDS::Edge(found->second.Oriented(from == key.first ? TopAbs_FORWARD : TopAbs_REVERSED));
  }

  TopoDS_Wire wire(const CornerLoop& loop) {
    TopoDS_Wire wire;
    builder_.MakeWire(wire);
    for (size_t i = 0; i < loop.size(); ++i) builder_.Add(wire, edge(loop[i], loop[(i + 1) % loop.size()]));
    wire.Closed(true);
    return wire;
  }

  TopoDS_Face face(size_t index) {
    const PolyhedralFace& polygon = mesh_.faces[index];
    Vec3 centre = Vec3::Zero();
    for (size_t corner : polygon.outer) centre += mesh_.corners[corner];
    centre /= static_cast<double>(polygon.outer.size());
    const Vec3 area = double_area(mesh_, polygon.outer, centre);
    if (!(area.norm() > 0)) {
      throw PolyhedronFailure("face " + std::to_string(index) + " has no area; leave it out");
    }
    const Vec3 normal = area.normalized();

    double off_plane_mm = 0;
    for (size_t corner : polygon.outer) {
      off_plane_mm = std::max(off_plane_mm, std::abs(normal.dot(mesh_.corners[corner] - centre)));
    }
    if (off_plane_mm > tolerance_mm_) {
      throw PolyhedronFailure("face " + std::to_string(index) + " is not plane: a corner lies " +
                              std::to_string(off_plane_mm) + " mm off; split it into triangles");
    }

    TopoDS_Face face;
    const Handle(Geom_Plane) plane = new Geom_Plane(gp_Pnt(centre.x(), centre.y(), centre.z()),
                                                    gp_Dir(normal.x(), normal.y(), normal.z()));
    builder_.MakeFace(face, plane, Precision::Confusion());
    builder_.Add(face, wire(polygon.outer));
    for (const CornerLoop& hole : polygon.holes) builder_.Add(face, wire(hole));
    if (off_plane_mm > Precision::Confusion()) widen(polygon, off_plane_mm);
    return face;
  }

  void widen(const PolyhedralFace& polygon, double tolerance_mm) {
    const size_t n = polygon.outer.size();
    for (size_t i = 0; i < n; ++i) {
      builder_.UpdateEdge(edge(polygon.outer[i], polygon.outer[(i + 1) % n]), 1.01 * tolerance_mm);
      builder_.UpdateVertex(vertex(polygon.outer[i]), 1.01 * tolerance_mm);
    }
  }

  const PolyhedralMesh& mesh_;
  double tolerance_mm_;
  BRep_Builder builder_;
  std::vector<TopoDS_Vertex> vertices_;
  std::map<std::pair<size_t, size_t>, TopoDS_Edge> edges_;
};

}  // namespace

TopoDS_Shape polyhedral_solid(PolyhedralMesh mesh) {
  weld_corners(mesh);
  if (mesh.faces.size() < 4) throw PolyhedronFailure("it has fewer than four faces");
  check_closed(mesh);
  Vec3 low = mesh.corners[mesh.faces[0].outer[0]], high = low;
  for (const PolyhedralFace& face : mesh.faces) {
    for (size_t corner : face.outer) {
      low = low.cwiseMin(mesh.corners[corner]);
      high = high.cwiseMax(mesh.corners[corner]);
    }
  }
  const Vec3 middle = 0.5 * (low + high);
  const std::vector<std::vector<size_t>> surfaces = connected_surfaces(mesh);
  std::vector<double> volumes;
  for (const std::vector<size_t>& surface : surfaces) volumes.push_back(signed_volume(mesh, surface, middle));
  const double volume = std::accumulate(volumes.begin(), volumes.end(), 0.0);
  if (!(std::abs(volume) > 0)) throw PolyhedronFailure("it has no volume");
  if (volume < 0) turn_inside_out(mesh);

  std::vector<std::vector<size_t>> bodies, cavities;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    ((volumes[i] > 0) == (volume > 0) ? bodies : cavities).push_back(surfaces[i]);
  }
  const double size_mm =
      std::max((high - low).maxCoeff(), std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()));
  Builder builder(mesh, std::max(kSixDigits * size_mm, Precision::Confusion()));
  if (bodies.size() == 1) {
    cavities.insert(cavities.begin(), bodies[0]);
    return builder.solid(cavities);
  }
  if (!cavities.empty()) {
    throw PolyhedronFailure("it holds several bodies with cavities; make each body a polyhedron of its own");
  }
  BRep_Builder compound_builder;
  TopoDS_Compound compound;
  compound_builder.MakeCompound(compound);
  for (const std::vector<size_t>& body : bodies) compound_builder.Add(compound, builder.solid({body}));
  return compound;
}

}  // namespace tetragauge
