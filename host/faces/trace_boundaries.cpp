// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/trace_boundaries.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "host/faces/complete_labels.hpp"

namespace tetragauge {
namespace {

// A stretch of a face's boundary with one face beyond it.
struct Run {
  int32_t beyond = kNoRegion;
  std::vector<Vec3> middles;        // of the mesh edges that leave the face, in order
  Vec3 inside = Vec3::Zero();       // sum of their ends on the face
  double longest_mm = 0;            // of these mesh edges
  std::optional<MeetingLine> line;  // its direction: the way around the face
};

class Tracer {
 public:
  Tracer(const Reconstruction& reconstruction, const FittedFaces& fitted, std::vector<int32_t> labels)
      : reconstruction_(reconstruction),
        fits_(fitted.fits),
        label_(std::move(labels)),
        visited_(reconstruction.surface.size()) {}

  std::vector<std::vector<BoundaryLoop>> run() {
    std::vector<std::vector<BoundaryLoop>> result(fits_.size());
    for (uint32_t t = 0; t < visited_.size(); ++t) {
      for (uint32_t i = 0; i < 3; ++i) {
        const int32_t f = label_[vertex(t, i + 1)];
        if (visited_[t][i] || f == label_[vertex(t, i + 2)] || !is_face(f)) continue;
        trace(t, i, f, result[static_cast<size_t>(f)]);
      }
    }
    return result;
  }

 private:
  bool is_face(int32_t label) const { return label >= 0 && label < static_cast<int32_t>(fits_.size()); }
  uint32_t vertex(uint32_t t, uint32_t i) const { return reconstruction_.surface[t].vertex[i % 3]; }
  const Vec3& at(uint32_t t, uint32_t i) const { return reconstruction_.vertices[vertex(t, i)]; }

  // From triangle t, whose edge opposite vertex i leads out of face f, once around. With f on the left one
  // enters a triangle by an edge that leads out of f and leaves it by one that leads back.
  void trace(uint32_t t, uint32_t i, int32_t f, std::vector<BoundaryLoop>& loops) {
    std::vector<Run> runs;
    Vec3 low = at(t, i + 1), high = low;  // of the face's own vertices along the loop
    while (!visited_[t][i]) {
      visited_[t][i] = true;
      const Vec3 &inside = at(t, i + 1), &outside = at(t, i + 2);
      low = low.cwiseMin(inside);
      high = high.cwiseMax(inside);
      const int32_t beyond = label_[vertex(t, i + 2)];
      if (runs.empty() || runs.back().beyond != beyond) runs.push_back({beyond, {}, Vec3::Zero(), 0, {}});
      Run& run = runs.back();
      run.middles.push_back(0.5 * (inside + outside));
      run.inside += inside;
      run.longest_mm = std::max(run.longest_mm, (outside - inside).norm());
      uint32_t exit = (i + 1) % 3;
      if (label_[vertex(t, exit + 1)] == f || label_[vertex(t, exit + 2)] != f) exit = (i + 2) % 3;
      const auto next = static_cast<uint32_t>(reconstruction_.surface[t].neighbour[exit]);
      uint32_t entry = 0;
      while (entry < 3 && !(vertex(next, entry + 1) == vertex(t, exit + 2) &&
                            vertex(next, entry + 2) == vertex(t, exit + 1)))
        ++entry;
      if (entry == 3) return;  // an open surface: no loop
      t = next;
      i = entry;
    }
    // Within two spacings all round: a gap between points, no shape that can be told from one.
    if ((high - low).norm() < 2 * reconstruction_.vertex_spacing_mm) return;
    join(runs);
    runs = drop_doubtful(f, std::move(runs));
    // Along one line to and fro: the mesh winds about an edge there.
    if (runs.size() == 1 && runs.front().line) return;
    BoundaryLoop loop = polygon(f, runs);
    if (loop.size() > 2) loops.push_back(std::move(loop));
  }

  // The first and last run are one where the walk began in its middle; so are neighbours with one face
  // beyond.
  static void join(std::vector<Run>& runs) {
    const auto append = [](Run& to, const Run& more) {
      to.middles.insert(to.middles.end(), more.middles.begin(), more.middles.end());
      to.inside += more.inside;
      to.longest_mm = std::max(to.longest_mm, more.longest_mm);
    };
    for (size_t k = 1; k < runs.size();) {
      if (runs[k].beyond != runs[k - 1].beyond) {
        ++k;
        continue;
      }
      append(runs[k - 1], runs[k]);
      runs.erase(runs.begin() + static_cast<long>(k));
    }
    if (runs.size() < 2 || runs.front().beyond != runs.back().beyond) return;
    append(runs.back(), runs.front());
    runs.erase(runs.begin());
  }

  // Which way along the line is around the face follows from the side of it that the face's own vertices lie
  // on. (The way the mesh edges lead is no help where the faces meet in an acute angle, in the depth of a
  // notch.)
  void give_line(int32_t f, Run& run) const {
    if (!is_face(run.beyond)) return;
    const PlaneFit &own = fits_[static_cast<size_t>(f)], &other = fits_[static_cast<size_t>(run.beyond)];
    run.line = meeting_line(own, other);
    if (!run.line) return;
    Vec3 out = other.normal - own.normal * own.normal.dot(other.normal);
    const Vec3 inside = run.inside / static_cast<double>(run.middles.size());
    if (out.dot(run.line->foot(inside) - inside) < 0) out = -out;
    run.line->direction = own.normal.cross(out).normalized();
  }

  std::optional<Vec3> corner(int32_t f, const Run& a, const Run& b) const {
    if (!a.line || !b.line) return std::nullopt;
    constexpr double kParallel = 0.05;
    if (a.line->direction.cross(b.line->direction).norm() < kParallel) return std::nullopt;
    const PlaneFit* p[3] = {&fits_[static_cast<size_t>(f)], &fits_[static_cast<size_t>(a.beyond)],
                            &fits_[static_cast<size_t>(b.beyond)]};
    Mat3 normals;
    Vec3 offsets;
    const Vec3 base = a.middles.back();
    for (int k = 0; k < 3; ++k) {
      normals.row(k) = p[k]->normal.transpose();
      offsets[k] = p[k]->d_mm - p[k]->normal.dot(base);
    }
    const Vec3 point = normals.partialPivLu().solve(offsets);
    // Beyond the last vertices there are at most some spacings to the corner, or the shadow's width.
    const double reach = 3 * reconstruction_.vertex_spacing_mm + 1.5 * std::max(a.longest_mm, b.longest_mm);
    if (!point.allFinite() || point.norm() > reach) return std::nullopt;
    return base + point;
  }

  // Noise at a corner makes a face follow that is none there. It shows: it would have to be walked backwards,
  // or its corners lie nowhere near.
  std::vector<Run> drop_doubtful(int32_t f, std::vector<Run> runs) const {
    constexpr size_t kFew = 4;  // mesh edges: the boundary goes on for at least two spacings in a real one
    // Between two runs along one line there is nothing, but for rounding.
    const double nothing_mm = 1e-6 * reconstruction_.vertex_spacing_mm;
    for (Run& run : runs) give_line(f, run);
    while (runs.size() > 2) {
      size_t worst = runs.size(), fewest = SIZE_MAX;
      const auto doubt = [&](size_t k) {
        if (runs[k].middles.size() >= fewest) return;
        worst = k;
        fewest = runs[k].middles.size();
      };
      for (size_t k = 0; k < runs.size(); ++k) {
        const size_t before = (k + runs.size() - 1) % runs.size(), after = (k + 1) % runs.size();
        const auto from = corner(f, runs[before], runs[k]), to = corner(f, runs[k], runs[after]);
        if (from && to && runs[k].line->direction.dot(*to - *from) <= nothing_mm) doubt(k);
        if (!from && runs[k].middles.size() < kFew) doubt(k);
        if (!to && runs[k].middles.size() < kFew) doubt(k);
      }
      if (worst == runs.size()) break;
      runs.erase(runs.begin() + static_cast<long>(worst));
      join(runs);
      for (Run& run : runs) give_line(f, run);
    }
    return runs;
  }

  BoundaryLoop polygon(int32_t f, const std::vector<Run>& runs) const {
    const PlaneFit& plane = fits_[static_cast<size_t>(f)];
    const auto on_plane = [&](const Vec3& p) -> Vec3 {
      return p - plane.normal * (plane.normal.dot(p) - plane.d_mm);
    };
    BoundaryLoop loop;
    for (size_t k = 0; k < runs.size(); ++k) {
      const Run& run = runs[k];
      const int32_t beyond = is_face(run.beyond) ? run.beyond : kNoRegion;
      if (!run.line || runs.size() < 2) {
        for (const Vec3& p : run.middles) loop.push_back({on_plane(p), beyond});
        continue;
      }
      const auto from =
          runs.size() > 2 ? corner(f, runs[(k + runs.size() - 1) % runs.size()], run) : std::optional<Vec3>();
      const auto to = runs.size() > 2 ? corner(f, run, runs[(k + 1) % runs.size()]) : std::optional<Vec3>();
      loop.push_back({from ? *from : run.line->foot(run.middles.front()), beyond});
      if (!to) loop.push_back({run.line->foot(run.middles.back()), beyond});
    }
    return loop;
  }

  const Reconstruction& reconstruction_;
  const std::vector<PlaneFit>& fits_;
  std::vector<int32_t> label_;
  std::vector<std::array<bool, 3>> visited_;  // per triangle, edge opposite vertex i
};

}  // namespace

std::optional<MeetingLine> meeting_line(const PlaneFit& f, const PlaneFit& g) {
  const Vec3 direction = f.normal.cross(g.normal);
  const double sine2 = direction.squaredNorm();
  if (sine2 < 7.6e-5) return std::nullopt;  // half a degree
  const Vec3 point = (f.d_mm * g.normal.cross(direction) + g.d_mm * direction.cross(f.normal)) / sine2;
  return MeetingLine{point, direction / std::sqrt(sine2)};
}

std::vector<std::vector<BoundaryLoop>> trace_boundaries(const Reconstruction& reconstruction,
                                                        const SurfaceGraph& graph,
                                                        const FittedFaces& fitted) {
  return Tracer(reconstruction, fitted, complete_labels(reconstruction, graph, fitted)).run();
}

}  // namespace tetragauge
