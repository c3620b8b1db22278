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
  double weight;
  int measured, group;
};

struct Peak {
  double shift_mm, explained;
};

// Each measured face counts once, where it weighs most; and a model plane with more on it than its area
// only in that proportion. Kept between
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
  double total(const PlaneSet& model, const PlaneSet& measured) {
    groups_.clear();
    for (const size_t j : measured_) {
      Sum& sum = sum_[best_[j].group];
      if (sum.when != now_) {
        sum = {now_, 0, 0};
        groups_.push_back(best_[j].group);
      }
      sum.weight += best_[j].weight;
      sum.area_mm2 += measured.planes[j].area_mm2;
    }
    double total = 0;
    for (const size_t g : groups_) {
      const double most_mm2 = kAreaSlack * model.group_area_mm2[g];
      total += sum_[g].weight * (sum_[g].area_mm2 > most_mm2 ? most_mm2 / sum_[g].area_mm2 : 1);
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
    double weight = 0, area_mm2 = 0;
  };
  uint64_t now_ = 0;
  std::vector<Best> best_;
  std::vector<Sum> sum_;
  std::vector<size_t> measured_, groups_;  // offered since the beginning
};

class Line {
 public:
  Vec3 u = Vec3::Zero();
  std::vector<Term> terms;  // by shift
  std::vector<Peak> peaks;  // by explained area, descending

  double explained(double shift_mm, double gate_mm, const PlaneSet& model, const PlaneSet& measured,
                   Tally& tally) const {
    tally.begin();
    auto term = std::lower_bound(terms.begin(), terms.end(), shift_mm - gate_mm,
                                 [](const Term& a, double s) { return a.shift_mm < s; });
    for (; term != terms.end() && term->shift_mm <= shift_mm + gate_mm; ++term) {
      const double share = (term->shift_mm - shift_mm) / gate_mm;
      tally.offer(static_cast<size_t>(term->measured), static_cast<size_t>(term->group),
                  term->weight * (1 - share * share));
    }
    return tally.total(model, measured);
  }

  void find_peaks(double gate_mm, const PlaneSet& model, const PlaneSet& measured, Tally& tally) {
    std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) {
      if (a.shift_mm != b.shift_mm) return a.shift_mm < b.shift_mm;
      return a.measured != b.measured ? a.measured < b.measured : a.group < b.group;
    });
    // A seventh of the gate off the summit costs a fiftieth of it at most.
    std::vector<Peak> all;
    for (const Term& term : terms) {
      if (!all.empty() && term.shift_mm - all.back().shift_mm < 0.14 * gate_mm) continue;
      all.push_back({term.shift_mm, explained(term.shift_mm, gate_mm, model, measured, tally)});
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Peak& a, const Peak& b) { return a.explained > b.explained; });
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
                 double at_least, double keep)
      : model_(model),
        measured_(measured),
        R_(R),
        gates_(gates),
        bound_(at_least),
        keep_(keep),
        tally_(measured.planes.size(), model.group_area_mm2.size()) {
    collect_lines();
    rest_.assign(lines_.size() + 1, 0.0);
    for (size_t k = lines_.size(); k-- > 0;) rest_[k] = rest_[k + 1] + lines_[k].peaks.front().explained;
  }

  std::vector<PoseCandidate> run() {
    Fixed none;
    descend(0, 0, none);
    std::erase_if(found_, [&](const PoseCandidate& pose) { return pose.explained < bound_; });
    std::stable_sort(found_.begin(), found_.end(),
                     [](const auto& a, const auto& b) { return a.explained > b.explained; });
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
    // The mean of a direction is no farther from its faces' normals than twice the angle they share.
    const double least_near = std::cos(gates_.angle_rad + 2 * model_.direction_rad);
    std::vector<Vec3> turned, points;
    for (const MatchPlane& seen : measured_.planes) {
      turned.push_back(R_ * seen.normal);
      points.push_back(R_ * seen.point_mm);
    }
    const auto cosine_to = [&](const Vec3& normal, size_t j) {
      const double cosine = turned[j].dot(normal);
      return gates_.is_unsigned ? std::abs(cosine) : cosine;
    };
    for (size_t k = 0; k < model_.directions.size(); ++k) {
      std::vector<size_t> near;
      for (size_t j = 0; j < turned.size(); ++j)
        if (cosine_to(model_.directions[k].normal, j) >= least_near) near.push_back(j);
      if (near.empty()) continue;
      for (const size_t i : model_.planes_along[k]) {
        const MatchPlane& face = model_.planes[i];
        Line& line = line_along(face.normal);
        const double sense = line.u.dot(face.normal) > 0 ? 1 : -1;
        for (const size_t j : near) {
          const double cosine = cosine_to(face.normal, j);
          if (cosine < least_cosine || !gates_.allowed(i, j)) continue;
          const MatchPlane& seen = measured_.planes[j];
          // The square of a small angle: 2 (1 - cos).
          const double share2 = 2 * (1 - cosine) / (gates_.angle_rad * gates_.angle_rad);
          line.terms.push_back({sense * (face.d_mm - face.normal.dot(points[j])),
                                seen.weight * std::max(0.0, 1 - share2), static_cast<int>(j), face.group});
        }
      }
    }
    std::erase_if(lines_, [](const Line& line) { return line.terms.empty(); });
    for (Line& line : lines_) line.find_peaks(gates_.offset_mm, model_, measured_, tally_);
    std::stable_sort(lines_.begin(), lines_.end(), [](const Line& a, const Line& b) {
      return a.peaks.front().explained > b.peaks.front().explained;
    });
  }

  Line& line_along(const Vec3& normal) {
    for (Line& line : lines_)
      if (std::abs(line.u.dot(normal)) > 1 - 1e-8) return line;
    lines_.emplace_back();
    lines_.back().u = normal;
    return lines_.back();
  }

  void descend(size_t k, double gained, const Fixed& fixed) {
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
      descend(k + 1, gained + line.peaks.front().explained, fixed);
      return;
    }
    for (const Peak& peak : line.peaks) {
      if (gained + peak.explained + rest_[k + 1] < bound_) break;
      Fixed next = fixed;
      next.axis[static_cast<size_t>(fixed.rank)] = across / rest;
      next.shift[static_cast<size_t>(fixed.rank)] = (peak.shift_mm - along) / rest;
      next.rank = fixed.rank + 1;
      descend(k + 1, gained + peak.explained, next);
    }
    // Every face along this line may be an extra one.
    if (gained + rest_[k + 1] >= bound_) descend(k + 1, gained, fixed);
  }

  void finish(const Fixed& fixed) {
    if (fixed.rank == 0) return;
    Vec3 t = unbounded_part(fixed);
    for (int i = 0; i < fixed.rank; ++i)
      t += fixed.shift[static_cast<size_t>(i)] * fixed.axis[static_cast<size_t>(i)];
    double explained = 0;
    for (const Line& line : lines_)
      explained += line.explained(line.u.dot(t), gates_.offset_mm, model_, measured_, tally_);
    if (explained < bound_ || !holds_fixed(model_, measured_, {R_, t}, gates_, true)) return;
    bound_ = std::max(bound_, keep_ * explained);  // the first leaf is a good one, and cuts the rest
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
            if (pose.explained > other.explained) other = pose;
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
  double bound_, keep_;
  Tally tally_;
  std::vector<Line> lines_;
  std::vector<double> rest_;  // most that lines k.. can explain
  std::vector<PoseCandidate> found_;
  std::map<std::array<int64_t, 3>, std::vector<size_t>> cells_;  // indices into found_, where they came first
};

}  // namespace

std::vector<PoseCandidate> search_translations(const PlaneSet& model, const PlaneSet& measured, const Mat3& R,
                                               const SearchGates& gates, double at_least, double keep) {
  return BranchAndBound(model, measured, R, gates, at_least, keep).run();
}

}  // namespace tetragauge
