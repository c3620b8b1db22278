// SPDX-License-Identifier: GPL-3.0-or-later
// Once the rotation stands, a pair of faces (model i, measured j) says only where the part lies along the
// model normal, so the explained area is a sum of functions of one variable, one for each line of normals:
// E(t) = sum_k S_k(u_k . t). Three lines fix t; a branch-and-bound over the peaks of the S_k finds every t
// above a bound, because what the remaining lines can still add is known (the sum of their highest peaks).
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "host/match/search_poses.hpp"

namespace tetragauge {
namespace {

struct Term {
  double shift_mm;  // u . t that puts measured face j on model face i
  double weight_mm2;
  int measured, group;
};

struct Peak {
  double shift_mm, explained_mm2;
};

// Each measured face counts once, where it weighs most; each model plane no more than its area. Kept between
// calls, so that starting anew costs nothing.
class Tally {
 public:
  Tally(size_t measured, size_t groups) : best_(measured), sum_(groups) {}

  void begin() {
    ++now_;
    measured_.clear();
  }
  void offer(size_t measured, size_t group, double weight) {
    Best& best = best_[measured];
    if (best.when != now_) {
      best = {now_, group, weight};
      measured_.push_back(measured);
    } else if (weight > best.weight) {
      best.group = group;
      best.weight = weight;
    }
  }
  double total(const PlaneSet& model) {
    double total = 0;
    for (const size_t j : measured_) {
      Sum& sum = sum_[best_[j].group];
      if (sum.when != now_) sum = {now_, 0};
      const double most = kAreaSlack * model.group_area_mm2[best_[j].group];
      const double before = std::min(sum.weight, most);
      sum.weight += best_[j].weight;
      total += std::min(sum.weight, most) - before;
    }
    return total;
  }

 private:
  struct Best {
    uint64_t when = 0;
    size_t group = 0;
    double weight = 0;
  };
  struct Sum {
    uint64_t when = 0;
    double weight = 0;
  };
  uint64_t now_ = 0;
  std::vector<Best> best_;
  std::vector<Sum> sum_;
  std::vector<size_t> measured_;  // offered since the beginning
};

class Line {
 public:
  Vec3 u = Vec3::Zero();
  std::vector<Term> terms;  // by shift
  std::vector<Peak> peaks;  // by explained area, descending

  double explained(double shift_mm, double gate_mm, const PlaneSet& model, Tally& tally) const {
    tally.begin();
    auto term = std::lower_bound(terms.begin(), terms.end(), shift_mm - gate_mm,
                                 [](const Term& a, double s) { return a.shift_mm < s; });
    for (; term != terms.end() && term->shift_mm <= shift_mm + gate_mm; ++term) {
      const double share = (term->shift_mm - shift_mm) / gate_mm;
      tally.offer(static_cast<size_t>(term->measured), static_cast<size_t>(term->group),
                  term->weight_mm2 * (1 - share * share));
    }
    return tally.total(model);
  }

  void find_peaks(double gate_mm, const PlaneSet& model, Tally& tally) {
    std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) {
      return std::tie(a.shift_mm, a.measured, a.group) < std::tie(b.shift_mm, b.measured, b.group);
    });
    // A tenth of the gate off the summit costs a hundredth of it at most.
    std::vector<Peak> all;
    for (const Term& term : terms) {
      if (!all.empty() && term.shift_mm - all.back().shift_mm < 0.1 * gate_mm) continue;
      all.push_back({term.shift_mm, explained(term.shift_mm, gate_mm, model, tally)});
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Peak& a, const Peak& b) { return a.explained_mm2 > b.explained_mm2; });
    for (const Peak& peak : all) {
      const bool near = std::any_of(peaks.begin(), peaks.end(), [&](const Peak& other) {
        return std::abs(other.shift_mm - peak.shift_mm) < 0.4 * gate_mm;
      });
      if (!near) peaks.push_back(peak);
    }
  }
};

class BranchAndBound {
 public:
  BranchAndBound(const PlaneSet& model, const PlaneSet& measured, const Mat3& R, const SearchGates& gates,
                 double at_least_mm2, double keep)
      : model_(model),
        measured_(measured),
        R_(R),
        gates_(gates),
        bound_mm2_(at_least_mm2),
        keep_(keep),
        tally_(measured.planes.size(), model.group_area_mm2.size()) {
    collect_lines();
    rest_mm2_.assign(lines_.size() + 1, 0.0);
    for (size_t k = lines_.size(); k-- > 0;)
      rest_mm2_[k] = rest_mm2_[k + 1] + lines_[k].peaks.front().explained_mm2;
  }

  std::vector<PoseCandidate> run() {
    Fixed none;
    descend(0, 0, none);
    std::erase_if(found_, [&](const PoseCandidate& pose) { return pose.explained_mm2 < bound_mm2_; });
    std::stable_sort(found_.begin(), found_.end(),
                     [](const auto& a, const auto& b) { return a.explained_mm2 > b.explained_mm2; });
    return std::move(found_);
  }

 private:
  struct Fixed {
    int rank = 0;
    std::array<Vec3, 3> axis{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // orthonormal
    std::array<double, 3> shift{};                                       // axis . t
  };

  void collect_lines() {
    const double least_cosine = std::cos(gates_.angle_rad);
    for (size_t i = 0; i < model_.planes.size(); ++i) {
      const MatchPlane& face = model_.planes[i];
      for (size_t j = 0; j < measured_.planes.size(); ++j) {
        const MatchPlane& seen = measured_.planes[j];
        const Vec3 turned = R_ * seen.normal;
        const double cosine =
            gates_.is_unsigned ? std::abs(turned.dot(face.normal)) : turned.dot(face.normal);
        if (cosine < least_cosine || !gates_.allowed(i, j)) continue;
        const double share = std::acos(std::min(1.0, cosine)) / gates_.angle_rad;
        Line& line = line_along(face.normal);
        const double sense = line.u.dot(face.normal) > 0 ? 1 : -1;
        line.terms.push_back({sense * (face.d_mm - face.normal.dot(R_ * seen.point_mm)),
                              seen.area_mm2 * (1 - share * share), static_cast<int>(j), face.group});
      }
    }
    for (Line& line : lines_) line.find_peaks(gates_.offset_mm, model_, tally_);
    std::stable_sort(lines_.begin(), lines_.end(), [](const Line& a, const Line& b) {
      return a.peaks.front().explained_mm2 > b.peaks.front().explained_mm2;
    });
  }

  Line& line_along(const Vec3& normal) {
    for (Line& line : lines_)
      if (std::abs(line.u.dot(normal)) > 1 - 1e-8) return line;
    lines_.emplace_back();
    lines_.back().u = normal;
    return lines_.back();
  }

  void descend(size_t k, double gained_mm2, const Fixed& fixed) {
    if (fixed.rank == 3 || k == lines_.size()) {
      finish(fixed);
      return;
    }
    const Line& line = lines_[k];
    Vec3 across = line.u;
    double along = 0;  // u . t as far as it is fixed
    for (int i = 0; i < fixed.rank; ++i) {
      const double share = fixed.axis[static_cast<size_t>(i)].dot(line.u);
      across -= share * fixed.axis[static_cast<size_t>(i)];
      along += share * fixed.shift[static_cast<size_t>(i)];
    }
    const double rest = across.norm();
    if (rest < 0.05) {  // within 3 degrees of what is fixed: it can only agree or not
      descend(k + 1, gained_mm2 + line.peaks.front().explained_mm2, fixed);
      return;
    }
    for (const Peak& peak : line.peaks) {
      if (gained_mm2 + peak.explained_mm2 + rest_mm2_[k + 1] < bound_mm2_) break;
      Fixed next = fixed;
      next.axis[static_cast<size_t>(fixed.rank)] = across / rest;
      next.shift[static_cast<size_t>(fixed.rank)] = (peak.shift_mm - along) / rest;
      next.rank = fixed.rank + 1;
      descend(k + 1, gained_mm2 + peak.explained_mm2, next);
    }
    // Every face along this line may be an extra one.
    if (gained_mm2 + rest_mm2_[k + 1] >= bound_mm2_) descend(k + 1, gained_mm2, fixed);
  }

  void finish(const Fixed& fixed) {
    if (fixed.rank == 0) return;
    Vec3 t = unbounded_part(fixed);
    for (int i = 0; i < fixed.rank; ++i)
      t += fixed.shift[static_cast<size_t>(i)] * fixed.axis[static_cast<size_t>(i)];
    double explained = 0;
    for (const Line& line : lines_)
      explained += line.explained(line.u.dot(t), gates_.offset_mm, model_, tally_);
    if (explained < bound_mm2_ || !holds_fixed(model_, measured_, {R_, t}, gates_, true)) return;
    bound_mm2_ = std::max(bound_mm2_, keep_ * explained);  // the first leaf is a good one, and cuts the rest
    add({{R_, t}, explained});
  }

  // One pose for all within half a gate: the one that explains most. Poses are looked up by cells of that
  // size.
  void add(const PoseCandidate& pose) {
    const double near_mm = 0.5 * gates_.offset_mm;
    const auto cell_of = [&](const Vec3& t) {
      return std::array<int64_t, 3>{std::llround(t.x() / near_mm), std::llround(t.y() / near_mm),
                                    std::llround(t.z() / near_mm)};
    };
    const std::array<int64_t, 3> cell = cell_of(pose.T_model_part.t);
    for (int64_t x = cell[0] - 1; x <= cell[0] + 1; ++x)
      for (int64_t y = cell[1] - 1; y <= cell[1] + 1; ++y)
        for (int64_t z = cell[2] - 1; z <= cell[2] + 1; ++z) {
          const auto at = cells_.find({x, y, z});
          if (at == cells_.end()) continue;
          for (const size_t k : at->second) {
            PoseCandidate& other = found_[k];
            if ((other.T_model_part.t - pose.T_model_part.t).norm() >= near_mm) continue;
            if (pose.explained_mm2 > other.explained_mm2) other = pose;
            return;
          }
        }
    cells_[cell].push_back(found_.size());
    found_.push_back(pose);
  }

  // Along directions that no face bounds: centroid on centroid.
  Vec3 unbounded_part(const Fixed& fixed) const {
    Vec3 t = model_.centroid_mm - R_ * measured_.centroid_mm;
    for (int i = 0; i < fixed.rank; ++i)
      t -= fixed.axis[static_cast<size_t>(i)] * fixed.axis[static_cast<size_t>(i)].dot(t);
    return t;
  }

  const PlaneSet& model_;
  const PlaneSet& measured_;
  Mat3 R_;
  SearchGates gates_;
  double bound_mm2_, keep_;
  Tally tally_;
  std::vector<Line> lines_;
  std::vector<double> rest_mm2_;  // most that lines k.. can explain
  std::vector<PoseCandidate> found_;
  std::map<std::array<int64_t, 3>, std::vector<size_t>> cells_;  // indices into found_, where they came first
};

}  // namespace

std::vector<PoseCandidate> search_translations(const PlaneSet& model, const PlaneSet& measured, const Mat3& R,
                                               const SearchGates& gates, double at_least_mm2, double keep) {
  return BranchAndBound(model, measured, R, gates, at_least_mm2, keep).run();
}

}  // namespace tetragauge
