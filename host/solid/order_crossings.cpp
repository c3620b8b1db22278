// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/order_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace tetragauge {
namespace {

bool share_a_corner(const Solid& solid, uint32_t a, uint32_t b) {
  for (const uint32_t v : solid.triangles[a]) {
    for (const uint32_t w : solid.triangles[b]) {
      if (v == w) return true;
    }
  }
  return false;
}

// Where the line meets an edge, its triangles are hit at one place, in any order: those that say the same are
// one hit, and what turns the right way goes first.
void sort_hits(const Solid& solid, double rounding_mm, std::vector<TriangleCrossing>& hits) {
  std::stable_sort(hits.begin(), hits.end(), [](const TriangleCrossing& a, const TriangleCrossing& b) {
    return a.crossing.t < b.crossing.t;
  });
  bool is_in = false;
  for (size_t i = 0; i < hits.size(); ++i) {
    const auto is_here = [&](size_t k) {
      return k < hits.size() && hits[k].crossing.t - hits[i].crossing.t <= rounding_mm;
    };
    if (hits[i].crossing.is_entering == is_in && is_here(i + 1) && hits[i + 1].crossing.is_entering != is_in)
      std::swap(hits[i], hits[i + 1]);
    is_in = hits[i].crossing.is_entering;
    while (is_here(i + 1) && hits[i + 1].crossing.is_entering == is_in &&
           share_a_corner(solid, hits[i].crossing.triangle, hits[i + 1].crossing.triangle)) {
      hits.erase(hits.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
  }
}

struct Match {
  double distance_mm = 0;
  size_t hit = 0, known = 0;
};

// For each hit the crossing that it stands for: of the same face, the same way, the nearest pairs first.
std::vector<std::optional<size_t>> match(const Solid& solid, const std::vector<TriangleCrossing>& hits,
                                         const std::vector<Crossing>& known, std::vector<char>& is_matched) {
  std::vector<Match> matches;
  for (size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_curved) continue;
    const Crossing& hit = hits[i].crossing;
    for (size_t k = 0; k < known.size(); ++k) {
      const double distance = std::abs(known[k].t - hit.t);
      if (known[k].is_entering == hit.is_entering && distance <= hits[i].reach_mm &&
          solid.triangle_face[known[k].triangle] == solid.triangle_face[hit.triangle])
        matches.push_back({distance, i, k});
    }
  }
  std::sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) {
    return std::tuple(a.distance_mm, a.hit, a.known) < std::tuple(b.distance_mm, b.hit, b.known);
  });
  std::vector<std::optional<size_t>> known_of_hit(hits.size());
  for (const Match& m : matches) {
    if (known_of_hit[m.hit] || is_matched[m.known]) continue;
    known_of_hit[m.hit] = m.known;
    is_matched[m.known] = 1;
  }
  return known_of_hit;
}

}  // namespace

std::vector<Crossing> order_crossings(const Solid& solid, std::vector<TriangleCrossing> hits,
                                      const std::vector<Crossing>& known, double rounding_mm) {
  sort_hits(solid, rounding_mm, hits);
  std::vector<char> is_matched(known.size());
  const std::vector<std::optional<size_t>> known_of_hit = match(solid, hits, known, is_matched);

  std::vector<Crossing> ordered;
  const auto append = [&](const Crossing& crossing) {
    ordered.push_back(crossing);
    if (ordered.size() > 1) ordered.back().t = std::max(crossing.t, ordered[ordered.size() - 2].t);
  };
  const auto is_passed = [&](size_t i) { return hits[i].is_curved && hits[i].is_flat && !known_of_hit[i]; };
  for (size_t i = 0; i < hits.size(); ++i) {
    // A triangle that stands out of a hollow face is met, in and out, by a line that passes the face.
    if (i + 1 < hits.size() && is_passed(i) && is_passed(i + 1) &&
        hits[i].crossing.is_entering != hits[i + 1].crossing.is_entering &&
        solid.triangle_face[hits[i].crossing.triangle] ==
            solid.triangle_face[hits[i + 1].crossing.triangle]) {
      ++i;
      continue;
    }
    append(known_of_hit[i] ? known[*known_of_hit[i]] : hits[i].crossing);
  }
  // What the triangles have missed, in pairs, where it fits between two of the others.
  for (size_t k = 0; k + 1 < known.size(); ++k) {
    if (is_matched[k] || is_matched[k + 1] || known[k].is_entering == known[k + 1].is_entering) continue;
    const auto after =
        std::find_if(ordered.begin(), ordered.end(), [&](const Crossing& c) { return c.t > known[k].t; });
    const bool is_in = after != ordered.begin() && (after - 1)->is_entering;
    if (is_in == known[k].is_entering || (after != ordered.end() && after->t <= known[k + 1].t)) continue;
    ordered.insert(after, {known[k], known[k + 1]});
    ++k;
  }
  // In and out at one place is nothing.
  for (size_t i = 0; i + 1 < ordered.size();) {
    if (ordered[i].is_entering && !ordered[i + 1].is_entering && ordered[i + 1].t <= ordered[i].t) {
      ordered.erase(ordered.begin() + static_cast<std::ptrdiff_t>(i),
                    ordered.begin() + static_cast<std::ptrdiff_t>(i) + 2);
    } else {
      ++i;
    }
  }
  return ordered;
}

}  // namespace tetragauge
