// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/close_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <numeric>

namespace tetragauge {
namespace {

using Triangle = std::array<uint32_t, 3>;

// Corners closer than the first of these shares of the part's extent are one: a float keeps 6e-8 of a
// coordinate, six printed digits 5e-7. The wider ones are tried in turn where the surface does not close,
// with a warning.
constexpr std::array kWeldShares{1e-6, 1e-5, 1e-4};

std::string text(const Vec3& p) {
  char line[100];
  std::snprintf(line, sizeof line, "(%.6g, %.6g, %.6g) mm", p.x(), p.y(), p.z());
  return line;
}

bool less(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

// Largest coordinate of a corner: what the digits of a file are relative to.
double extent_of(const TriangleMesh& mesh) {
  double extent = 0;
  for (const Triangle& t : mesh.triangles) {
    for (const uint32_t v : t) extent = std::max(extent, mesh.vertices[v].cwiseAbs().maxCoeff());
  }
  return extent;
}

// Sorted vertices, those within `reach` of one another merged into the least of them; triangles that lose a
// corner are dropped. Those not used by any triangle are left out.
ClosedMesh weld(const TriangleMesh& mesh, double reach_mm) {
  std::vector<uint32_t> used;
  for (const Triangle& t : mesh.triangles) used.insert(used.end(), t.begin(), t.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::stable_sort(used.begin(), used.end(),
                   [&](uint32_t a, uint32_t b) { return less(mesh.vertices[a], mesh.vertices[b]); });

  ClosedMesh welded;
  std::vector<uint32_t> index(mesh.vertices.size());
  // Kept vertices by cell of twice the reach: whatever is near lies in the cell or in one beside it.
  using Cell = std::array<int64_t, 3>;
  std::map<Cell, std::vector<uint32_t>> cells;
  const auto cell_of = [&](const Vec3& p, double shift) {
    Cell cell;
    for (int i = 0; i < 3; ++i) cell[static_cast<size_t>(i)] = std::llround((p[i] + shift) / (2 * reach_mm));
    return cell;
  };
  for (size_t i = 0; i < used.size(); ++i) {
    const uint32_t v = used[i];
    const Vec3& p = mesh.vertices[v];
    if (i > 0 && p == mesh.vertices[used[i - 1]]) {
      index[v] = index[used[i - 1]];
      continue;
    }
    const Cell low = cell_of(p, -reach_mm), high = cell_of(p, reach_mm);
    bool is_known = false;
    for (int64_t x = low[0]; x <= high[0] && !is_known; ++x) {
      for (int64_t y = low[1]; y <= high[1] && !is_known; ++y) {
        for (int64_t z = low[2]; z <= high[2] && !is_known; ++z) {
          const auto cell = cells.find({x, y, z});
          if (cell == cells.end()) continue;
          for (const uint32_t kept : cell->second) {
            if ((welded.vertices[kept] - p).cwiseAbs().maxCoeff() > reach_mm) continue;
            index[v] = kept;
            is_known = true;
            break;
          }
        }
      }
    }
    if (is_known) continue;
    index[v] = static_cast<uint32_t>(welded.vertices.size());
    cells[cell_of(p, 0)].push_back(index[v]);
    welded.vertices.push_back(p);
  }
  for (const Triangle& t : mesh.triangles) {
    Triangle own{index[t[0]], index[t[1]], index[t[2]]};
    if (own[0] == own[1] || own[1] == own[2] || own[2] == own[0]) continue;
    std::rotate(own.begin(), std::min_element(own.begin(), own.end()), own.end());
    welded.triangles.push_back(own);
  }
  std::sort(welded.triangles.begin(), welded.triangles.end());
  return welded;
}

Triangle turned(const Triangle& t) {
  return {t[0], t[2], t[1]};
}

// A triangle given twice is one; two back to back are a wall without thickness, and none.
void drop_doubles(ClosedMesh& mesh, const std::string& place) {
  std::map<Triangle, std::array<size_t, 2>> counts;  // by the turn whose second corner is the lesser
  for (const Triangle& t : mesh.triangles) {
    const bool is_turned = t[1] > t[2];
    ++counts[is_turned ? turned(t) : t][is_turned ? 1 : 0];
  }
  const size_t before = mesh.triangles.size();
  mesh.triangles.clear();
  for (const auto& [t, count] : counts) {
    if (count[0] > 0 && count[1] > 0) continue;
    mesh.triangles.push_back(count[0] > 0 ? t : turned(t));
  }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  const size_t dropped = before - mesh.triangles.size();
  if (dropped == 0) return;
  mesh.warnings.push_back(place + ": " + std::to_string(dropped) +
                          " triangles given twice or back to back are left out");
}

struct EdgeUse {
  uint32_t low, high, triangle, side;
  bool is_forward;
};

std::vector<EdgeUse> edge_uses(const std::vector<Triangle>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), i, k, a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::array{a.low, a.high, a.triangle, a.side} < std::array{b.low, b.high, b.triangle, b.side};
  });
  return uses;
}

struct EdgeCensus {
  size_t open = 0;     // edges of an odd number of triangles
  size_t crowded = 0;  // edges of four triangles or more
  std::array<uint32_t, 2> first_open{}, first_crowded{};
};

// Fills in the neighbours across edges of two triangles, and counts the others.
EdgeCensus link_neighbours(ClosedMesh& mesh) {
  const std::vector<EdgeUse> uses = edge_uses(mesh.triangles);
  mesh.neighbour.assign(mesh.triangles.size(), {kNoTriangle, kNoTriangle, kNoTriangle});
  EdgeCensus census;
  for (size_t i = 0, j = 0; i < uses.size(); i = j) {
    while (j < uses.size() && uses[j].low == uses[i].low && uses[j].high == uses[i].high) ++j;
    if (j - i == 2) {
      mesh.neighbour[uses[i].triangle][uses[i].side] = uses[i + 1].triangle;
      mesh.neighbour[uses[i + 1].triangle][uses[i + 1].side] = uses[i].triangle;
      continue;
    }
    const bool is_open = (j - i) % 2 == 1;
    if ((is_open ? census.open : census.crowded)++ == 0) {
      (is_open ? census.first_open : census.first_crowded) = {uses[i].low, uses[i].high};
    }
  }
  return census;
}

bool runs(const Triangle& t, uint32_t from, uint32_t to) {
  for (size_t k = 0; k < 3; ++k) {
    if (t[k] == from && t[(k + 1) % 3] == to) return true;
  }
  return false;
}

double signed_volume(const ClosedMesh& mesh, const std::vector<uint32_t>& members, const Vec3& origin) {
  double six = 0;
  for (const uint32_t i : members) {
    const Triangle& t = mesh.triangles[i];
    six += (mesh.vertices[t[0]] - origin)
               .dot((mesh.vertices[t[1]] - origin).cross(mesh.vertices[t[2]] - origin));
  }
  return six / 6;
}

void turn_all(ClosedMesh& mesh, const std::vector<uint32_t>& members) {
  for (const uint32_t i : members) {
    std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
    // Edges now run 0-2, 2-1, 1-0: the sides change places with them.
    std::swap(mesh.neighbour[i][0], mesh.neighbour[i][2]);
  }
}

// Pieces that hang together by edges, each turned one way round all over; an error for a one-sided surface.
Result<std::vector<std::vector<uint32_t>>> orient_pieces(ClosedMesh& mesh, const std::string& place) {
  const uint32_t count = static_cast<uint32_t>(mesh.triangles.size());
  std::vector<char> is_seen(count, 0), is_turned(count, 0);
  std::vector<std::vector<uint32_t>> pieces;
  size_t turned_count = 0;
  for (uint32_t first = 0; first < count; ++first) {
    if (is_seen[first]) continue;
    is_seen[first] = 1;
    std::vector<uint32_t> piece{first}, odd;
    for (size_t at = 0; at < piece.size(); ++at) {
      const uint32_t i = piece[at];
      const Triangle& t = mesh.triangles[i];
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t j = mesh.neighbour[i][k];
        if (j == kNoTriangle) continue;
        const bool is_same_way = !runs(mesh.triangles[j], t[k], t[(k + 1) % 3]);
        const char wanted = is_same_way ? is_turned[i] : static_cast<char>(!is_turned[i]);
        if (!is_seen[j]) {
          is_seen[j] = 1;
          is_turned[j] = wanted;
          piece.push_back(j);
        } else if (is_turned[j] != wanted) {
          return bad_input(place + ": the surface is one-sided near " + text(mesh.vertices[t[k]]) +
                           "; repair it in a mesh program and export it again");
        }
      }
    }
    std::sort(piece.begin(), piece.end());
    for (const uint32_t i : piece) {
      if (is_turned[i]) odd.push_back(i);
    }
    if (2 * odd.size() > piece.size()) {
      std::vector<uint32_t> rest;
      std::set_difference(piece.begin(), piece.end(), odd.begin(), odd.end(), std::back_inserter(rest));
      odd = std::move(rest);
    }
    turned_count += odd.size();
    turn_all(mesh, odd);
    pieces.push_back(std::move(piece));
  }
  if (turned_count > 0) {
    mesh.warnings.push_back(place + ": " + std::to_string(turned_count) + " of " + std::to_string(count) +
                            " triangles ran the other way round than their neighbours and are turned");
  }
  return pieces;
}

// How often the surface of `members` winds about p: van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30
// (1983) 125.
double winding_number(const ClosedMesh& mesh, const std::vector<uint32_t>& members, const Vec3& p) {
  double half_angles = 0;
  for (const uint32_t i : members) {
    const Vec3 a = mesh.vertices[mesh.triangles[i][0]] - p, b = mesh.vertices[mesh.triangles[i][1]] - p,
               c = mesh.vertices[mesh.triangles[i][2]] - p;
    const double na = a.norm(), nb = b.norm(), nc = c.norm();
    half_angles +=
        std::atan2(a.dot(b.cross(c)), na * nb * nc + a.dot(b) * nc + b.dot(c) * na + c.dot(a) * nb);
  }
  return half_angles / (2 * std::numbers::pi);
}

// Pieces that enclose material outward, cavities within them inward.
Status turn_outward(ClosedMesh& mesh, const std::vector<std::vector<uint32_t>>& pieces,
                    const std::string& place) {
  std::vector<double> volumes;
  for (const auto& piece : pieces)
    volumes.push_back(signed_volume(mesh, piece, mesh.vertices[mesh.triangles[piece[0]][0]]));
  if (std::accumulate(volumes.begin(), volumes.end(), 0.0) < 0) {
    for (size_t i = 0; i < pieces.size(); ++i) {
      turn_all(mesh, pieces[i]);
      volumes[i] = -volumes[i];
    }
    mesh.warnings.push_back(place + ": the surface was inside out and is turned");
  }
  for (size_t i = 0; i < pieces.size(); ++i) {
    if (volumes[i] >= 0) continue;
    const Triangle& t = mesh.triangles[pieces[i][0]];
    const Vec3 p = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
    bool is_cavity = false;
    for (size_t j = 0; j < pieces.size() && !is_cavity; ++j) {
      is_cavity = volumes[j] > 0 && winding_number(mesh, pieces[j], p) > 0.5;
    }
    if (is_cavity) continue;
    turn_all(mesh, pieces[i]);
    volumes[i] = -volumes[i];
    mesh.warnings.push_back(place + ": the body at " + text(p) + " was inside out and is turned");
  }
  for (const double volume : volumes) mesh.bodies += volume > 0;
  if (mesh.bodies == 0)
    return bad_input(place + ": the surface encloses no volume; export the part as a solid");
  return Done{};
}

// Edges of four triangles and more must still be run as often one way as the other.
Status check_balance(const ClosedMesh& mesh, const std::string& place) {
  const std::vector<EdgeUse> uses = edge_uses(mesh.triangles);
  for (size_t i = 0, j = 0; i < uses.size(); i = j) {
    int balance = 0;
    for (; j < uses.size() && uses[j].low == uses[i].low && uses[j].high == uses[i].high; ++j) {
      balance += uses[j].is_forward ? 1 : -1;
    }
    if (balance == 0) continue;
    return bad_input(
        place + ": more than two triangles meet at the edge from " + text(mesh.vertices[uses[i].low]) +
        " to " + text(mesh.vertices[uses[i].high]) +
        " and it is not clear what they enclose; repair it in a mesh program and export it again");
  }
  return Done{};
}

}  // namespace

Result<ClosedMesh> close_mesh(const TriangleMesh& file, const std::string& place) {
  if (file.triangles.empty()) {
    return bad_input(place + ": no triangles in it; a model must hold the closed surface of a part");
  }
  const double extent = extent_of(file);
  // A part in metres taken as one in micrometres is still within.
  if (!(extent >= 1e-9) || extent > 1e9) {
    char size[32];
    std::snprintf(size, sizeof size, "%g", extent);
    return bad_input(place + ": the part's size makes no sense (" + size +
                     " mm from the origin); check the file and its unit");
  }
  ClosedMesh mesh;
  EdgeCensus census;
  for (const double share : kWeldShares) {
    ClosedMesh tried = weld(file, share * extent);
    drop_doubles(tried, place);
    const EdgeCensus counted = link_neighbours(tried);
    if (share == kWeldShares.front() || counted.open == 0) {
      mesh = std::move(tried);
      census = counted;
      mesh.rounding_mm = share * extent;
    }
    if (counted.open > 0) continue;
    if (share > kWeldShares.front()) {
      mesh.warnings.push_back(place + ": the surface has gaps, closed by welding corners up to " +
                              std::to_string(share * extent) + " mm apart");
    }
    break;
  }
  if (mesh.triangles.empty())
    return bad_input(place + ": all its triangles are without area; export it again");
  if (census.open > 0) {
    return bad_input(place + ": the surface is open at " + std::to_string(census.open) +
                     " edges, the first from " + text(mesh.vertices[census.first_open[0]]) + " to " +
                     text(mesh.vertices[census.first_open[1]]) +
                     "; close it in the CAD system or a mesh program and export it again");
  }
  if (census.crowded > 0) {
    mesh.warnings.push_back(place + ": more than two triangles meet at " + std::to_string(census.crowded) +
                            " edges, the first at " + text(mesh.vertices[census.first_crowded[0]]) +
                            "; bodies touch there");
  }
  Result<std::vector<std::vector<uint32_t>>> pieces = orient_pieces(mesh, place);
  if (!pieces) return pieces.error();
  if (Status status = turn_outward(mesh, *pieces, place); !status) return status.error();
  if (census.crowded > 0) {
    if (Status status = check_balance(mesh, place); !status) return status.error();
  }
  return mesh;
}

}  // namespace tetragauge
