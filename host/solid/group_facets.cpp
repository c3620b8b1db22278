// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/group_facets.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace tetragauge {
namespace {

// A corner is off its plane by the rounding of its own coordinates and of those that gave the plane.
constexpr double kOffPlaneRoundings = 4;

// CAD systems turn by 10 to 30 degrees from one facet of a round face to the next (OpenCASCADE's and
// FreeCAD's default is 28.6); a twelve-sided prism turns by 30.
constexpr double kSmoothTurn_rad = 29.5 * std::numbers::pi / 180;

// Across their common edge two facets of one curved face are of like width, within this factor, but for those
// trimmed. A plane that runs out into a fillet is wider than the fillet's facets.
constexpr double kLikeWidth = 3;
// One that is trimmed is narrower than its neighbour, give or take.
constexpr double kTrimmedWidth = 1.5;

// A plane that runs out into a fillet turns by half of what the fillet's facets turn, for they are chords;
// and it is as wide as it likes.
constexpr double kLeastTangentShare = 0.4, kMostTangentShare = 0.6, kTangentWidth = 1.1;

// Fewer facets than this are as likely planes that were meant so.
constexpr size_t kFewestFacets = 4;

constexpr uint32_t kNoGroup = 0xFFFFFFFFu;

struct TriangleShape {
  Vec3 double_area = Vec3::Zero();
  double height_mm = 0;  // the least
  size_t longest = 0;    // side
};

TriangleShape shape_of(const ClosedMesh& mesh, uint32_t i) {
  const auto& t = mesh.triangles[i];
  TriangleShape shape;
  double longest_mm = 0;
  for (size_t k = 0; k < 3; ++k) {
    const double length = (mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]]).norm();
    if (length > longest_mm) {
      longest_mm = length;
      shape.longest = k;
    }
  }
  shape.double_area =
      (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
  shape.height_mm = shape.double_area.norm() / longest_mm;
  return shape;
}

class Grouper {
 public:
  explicit Grouper(const ClosedMesh& mesh)
      : mesh_(mesh),
        off_plane_mm_(kOffPlaneRoundings * mesh.rounding_mm),
        group_of_(mesh.triangles.size(), kNoGroup) {
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) shapes_.push_back(shape_of(mesh, i));
  }

  FacetGroups group(bool curved) {
    grow_planes();
    attach_slivers();
    if (curved) join_curved();
    collect();
    return {std::move(groups_), off_plane_mm_};
  }

 private:
  // A triangle thinner than this has no direction worth the name.
  bool is_sliver(uint32_t i) const { return shapes_[i].height_mm < 4 * off_plane_mm_; }

  bool is_on(uint32_t i, const Vec3& normal, double d_mm) const {
    for (const uint32_t v : mesh_.triangles[i]) {
      if (std::abs(normal.dot(mesh_.vertices[v]) - d_mm) > off_plane_mm_) return false;
    }
    return is_sliver(i) || shapes_[i].double_area.dot(normal) > 0;
  }

  std::vector<uint32_t> grow(uint32_t seed, const Vec3& normal, double d_mm, uint32_t number) {
    std::vector<uint32_t> members{seed};
    group_of_[seed] = number;
    for (size_t at = 0; at < members.size(); ++at) {
      for (const uint32_t j : mesh_.neighbour[members[at]]) {
        if (j == kNoTriangle || group_of_[j] != kNoGroup || !is_on(j, normal, d_mm)) continue;
        group_of_[j] = number;
        members.push_back(j);
      }
    }
    return members;
  }

  // Sets the plane from the triangles: their common vector area and centre.
  void fit(FacetGroup& group) const {
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    double area = 0;
    const Vec3& origin = mesh_.vertices[mesh_.triangles[group.triangles[0]][0]];
    for (const uint32_t i : group.triangles) {
      const auto& t = mesh_.triangles[i];
      const double own = shapes_[i].double_area.norm();
      sum += shapes_[i].double_area;
      moment += own *
                ((mesh_.vertices[t[0]] - origin) + (mesh_.vertices[t[1]] - origin) +
                 (mesh_.vertices[t[2]] - origin)) /
                3;
      area += own;
    }
    group.normal = sum.normalized();
    group.d_mm = group.normal.dot(origin + moment / area);
  }

  // Largest triangles first: their planes are the surest.
  void grow_planes() {
    std::vector<uint32_t> order(mesh_.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return shapes_[a].double_area.squaredNorm() > shapes_[b].double_area.squaredNorm();
    });
    for (const uint32_t seed : order) {
      if (group_of_[seed] != kNoGroup || is_sliver(seed)) continue;
      const uint32_t number = static_cast<uint32_t>(groups_.size());
      FacetGroup group;
      group.triangles = {seed};
      fit(group);
      // Twice: the second time from the plane of all, which a small seed only points to.
      for (int round = 0; round < 2; ++round) {
        for (const uint32_t i : group.triangles) group_of_[i] = kNoGroup;
        group.triangles = grow(seed, group.normal, group.d_mm, number);
        fit(group);
      }
      groups_.push_back(std::move(group));
    }
  }

  // Triangles without a direction go with the neighbour across their longest side.
  void attach_slivers() {
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (uint32_t i = 0; i < group_of_.size(); ++i) {
        if (group_of_[i] != kNoGroup) continue;
        for (size_t k = 0; k < 3 && group_of_[i] == kNoGroup; ++k) {
          const uint32_t j = mesh_.neighbour[i][(shapes_[i].longest + k) % 3];
          if (j == kNoTriangle || group_of_[j] == kNoGroup) continue;
          group_of_[i] = group_of_[j];
          groups_[group_of_[i]].triangles.push_back(i);
          is_changed = true;
        }
      }
    }
    // A body of slivers alone, far too small to measure: one group each.
    for (uint32_t i = 0; i < group_of_.size(); ++i) {
      if (group_of_[i] != kNoGroup) continue;
      group_of_[i] = static_cast<uint32_t>(groups_.size());
      FacetGroup group;
      group.is_plane = false;
      group.triangles = {i};
      groups_.push_back(std::move(group));
    }
  }

  struct SmoothPair {
    uint32_t a, b;                  // groups, a < b
    double width_a_mm, width_b_mm;  // across the common edge
    double turn_rad;
  };

  static double turn_between(const FacetGroup& a, const FacetGroup& b) {
    return std::atan2(a.normal.cross(b.normal).norm(), a.normal.dot(b.normal));
  }

  // How far the group reaches from the edge p-q, in its own plane.
  double width_across(const FacetGroup& group, const Vec3& p, const Vec3& q) const {
    const Vec3 across = group.normal.cross(q - p).normalized();
    double width = 0;
    for (const uint32_t i : group.triangles) {
      for (const uint32_t v : mesh_.triangles[i]) {
        width = std::max(width, std::abs(across.dot(mesh_.vertices[v] - p)));
      }
    }
    return width;
  }

  // Neighbouring groups that turn little from one to the other, seen at their longest common edge.
  std::vector<SmoothPair> smooth_pairs() const {
    struct Edge {
      double length_mm = 0;
      uint32_t from = 0, to = 0;
    };
    std::map<std::pair<uint32_t, uint32_t>, Edge> edges;
    for (uint32_t i = 0; i < group_of_.size(); ++i) {
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t j = mesh_.neighbour[i][k];
        if (j == kNoTriangle || j < i || group_of_[i] == group_of_[j]) continue;
        const FacetGroup &a = groups_[group_of_[i]], &b = groups_[group_of_[j]];
        if (!a.is_plane || !b.is_plane) continue;
        if (turn_between(a, b) > kSmoothTurn_rad) continue;
        const uint32_t from = mesh_.triangles[i][k], to = mesh_.triangles[i][(k + 1) % 3];
        const double length = (mesh_.vertices[to] - mesh_.vertices[from]).norm();
        Edge& edge = edges[std::minmax(group_of_[i], group_of_[j])];
        if (length > edge.length_mm) edge = {length, from, to};
      }
    }
    std::vector<SmoothPair> pairs;
    for (const auto& [groups, edge] : edges) {
      const Vec3 &p = mesh_.vertices[edge.from], &q = mesh_.vertices[edge.to];
      const FacetGroup &a = groups_[groups.first], &b = groups_[groups.second];
      pairs.push_back(
          {groups.first, groups.second, width_across(a, p, q), width_across(b, p, q), turn_between(a, b)});
    }
    drop_tangent(pairs);
    return pairs;
  }

  // Planes that run out into fillets all around belong apart from them.
  void drop_tangent(std::vector<SmoothPair>& pairs) const {
    std::vector<double> most_turn(groups_.size());
    for (const SmoothPair& pair : pairs) {
      for (const uint32_t g : {pair.a, pair.b}) most_turn[g] = std::max(most_turn[g], pair.turn_rad);
    }
    std::vector<char> is_tangent(groups_.size(), 1);
    const auto look = [&](uint32_t g, double width, uint32_t other, double other_width, double turn_rad) {
      const double share = turn_rad / most_turn[other];
      if (width < kTangentWidth * other_width || share < kLeastTangentShare || share > kMostTangentShare) {
        is_tangent[g] = 0;
      }
    };
    for (const auto& [a, b, width_a, width_b, turn] : pairs) {
      look(a, width_a, b, width_b, turn);
      look(b, width_b, a, width_a, turn);
    }
    std::erase_if(pairs, [&](const SmoothPair& pair) { return is_tangent[pair.a] || is_tangent[pair.b]; });
  }

  static uint32_t root(std::vector<uint32_t>& parent, uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  }

  void join_curved() {
    const std::vector<SmoothPair> pairs = smooth_pairs();
    std::vector<uint32_t> parent(groups_.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto join = [&](uint32_t a, uint32_t b) {
      const uint32_t ra = root(parent, a), rb = root(parent, b);
      parent[std::max(ra, rb)] = std::min(ra, rb);
    };
    for (const auto& [a, b, width_a, width_b, turn] : pairs) {
      if (std::max(width_a, width_b) < kLikeWidth * std::min(width_a, width_b)) join(a, b);
    }
    // Where an exporter's triangles do not pair up to strips, thin ones stand between two of like width.
    struct Side {
      uint32_t group;
      double width_mm;
    };
    std::vector<std::vector<Side>> wider(groups_.size());
    for (const auto& [a, b, width_a, width_b, turn] : pairs) {
      if (width_b > kLikeWidth * width_a) wider[a].push_back({b, width_b});
      if (width_a > kLikeWidth * width_b) wider[b].push_back({a, width_a});
    }
    std::vector<char> is_between(groups_.size());
    for (uint32_t g = 0; g < groups_.size(); ++g) {
      for (size_t i = 0; i < wider[g].size(); ++i) {
        for (size_t j = 0; j < i; ++j) {
          const Side &one = wider[g][i], &other = wider[g][j];
          if (std::max(one.width_mm, other.width_mm) > kLikeWidth * std::min(one.width_mm, other.width_mm))
            continue;
          if (turn_between(groups_[one.group], groups_[other.group]) > kSmoothTurn_rad) continue;
          join(one.group, g);
          join(other.group, g);
          is_between[g] = 1;
        }
      }
    }
    std::vector<size_t> size(groups_.size());
    for (uint32_t g = 0; g < groups_.size(); ++g) size[root(parent, g)] += !is_between[g];
    std::vector<char> is_curved(groups_.size());
    for (uint32_t g = 0; g < groups_.size(); ++g) is_curved[g] = size[root(parent, g)] >= kFewestFacets;
    // Curved regions that run into one another are one; trimmed, narrower facets beside one belong to it.
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (const auto& [a, b, width_a, width_b, turn] : pairs) {
        if (root(parent, a) == root(parent, b) || (!is_curved[a] && !is_curved[b])) continue;
        const bool is_trimmed = !is_curved[a] ? width_a < kTrimmedWidth * width_b
                                              : !is_curved[b] && width_b < kTrimmedWidth * width_a;
        if (!is_trimmed && !(is_curved[a] && is_curved[b])) continue;
        join(a, b);
        is_curved[a] = is_curved[b] = 1;
        is_changed = true;
      }
    }
    for (uint32_t i = 0; i < group_of_.size(); ++i) {
      const uint32_t g = group_of_[i];
      if (!is_curved[g]) continue;
      group_of_[i] = root(parent, g);
      groups_[group_of_[i]].is_plane = false;
    }
  }

  void collect() {
    for (FacetGroup& group : groups_) group.triangles.clear();
    for (uint32_t i = 0; i < group_of_.size(); ++i) groups_[group_of_[i]].triangles.push_back(i);
    std::erase_if(groups_, [](const FacetGroup& group) { return group.triangles.empty(); });
  }

  const ClosedMesh& mesh_;
  double off_plane_mm_;
  std::vector<uint32_t> group_of_;
  std::vector<TriangleShape> shapes_;
  std::vector<FacetGroup> groups_;
};

}  // namespace

FacetGroups group_facets(const ClosedMesh& mesh, bool curved) {
  return Grouper(mesh).group(curved);
}

}  // namespace tetragauge
