// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "host/match/search_poses.hpp"

namespace tetragauge {
namespace {

constexpr double kLeastSine = 0.1;  // two directions closer than 6 degrees turn a part badly
constexpr size_t kMostRotations = 512;

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The rotation that takes a to p and b to q as well as both can be (their bisectors exactly).
Mat3 rotation_from_pair(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q) {
  Mat3 from, to;
  const auto frame = [](const Vec3& x, const Vec3& y, Mat3& out) {
    out.col(0) = (x + y).normalized();
    out.col(1) = (x - y).normalized();
    out.col(2) = out.col(0).cross(out.col(1));
  };
  frame(a, b, from);
  frame(p, q, to);
  return to * from.transpose();
}

struct DirectionFit {
  double explained = 0;
  Mat3 refined = Mat3::Identity();
};

class DirectionScore {
 public:
  DirectionScore(const std::vector<PlaneDirection>& model, const PlaneSet& measured, double gate_rad)
      : model_(model), measured_(measured), gate_rad_(gate_rad) {}

  // Weight of the measured faces with a model direction; `gate_rad` is wide before the rotation is refined.
  double explained(const Mat3& R, double gate_rad, Mat3* scatter) {
    double total = 0;
    const double least_cosine = std::cos(gate_rad);
    for (const PlaneDirection& direction : measured_.directions) {
      const Vec3 turned = R * direction.normal;
      double best = least_cosine;
      size_t at = model_.size();
      for (size_t k = 0; k < model_.size(); ++k) {
        const double cosine = turned.dot(model_[k].normal);
        if (cosine > best) {
          best = cosine;
          at = k;
        }
      }
      if (at == model_.size()) continue;
      const double share = angle_between(turned, model_[at].normal) / gate_rad;
      const double agrees = 1 - share * share;
      total += direction.weight * agrees;
      // An extra face at the edge of the gate must not draw all the others off.
      if (scatter) *scatter += agrees * direction.area_mm2 * model_[at].normal * direction.normal.transpose();
    }
    return total;
  }

  // Kabsch (Acta Cryst. A32 (1976) 922) over the directions that agree; twice, as more agree after the first.
  RotationCandidate refined(Mat3 R) {
    for (int pass = 0; pass < 2; ++pass) {
      Mat3 scatter = Mat3::Zero();
      explained(R, 1.5 * gate_rad_, &scatter);
      const Eigen::JacobiSVD<Mat3> svd(scatter, Eigen::ComputeFullU | Eigen::ComputeFullV);
      if (svd.singularValues()[1] < 1e-3 * svd.singularValues()[0]) break;
      Vec3 sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
      R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
    }
    return {R, explained(R, gate_rad_, nullptr)};
  }

 private:
  const std::vector<PlaneDirection>& model_;
  const PlaneSet& measured_;
  double gate_rad_;
};

// With unsigned normals every model direction stands for both of its senses.
std::vector<PlaneDirection> both_senses(const PlaneSet& model, bool is_unsigned) {
  std::vector<PlaneDirection> directions = model.directions;
  if (!is_unsigned) return directions;
  std::vector<PlaneDirection> lines;
  for (const PlaneDirection& direction : directions) {
    const auto same = std::find_if(lines.begin(), lines.end(), [&](const PlaneDirection& line) {
      return std::abs(line.normal.dot(direction.normal)) > 1 - 1e-6;
    });
    if (same != lines.end()) {
      same->area_mm2 += direction.area_mm2;
    } else {
      lines.push_back(direction);
    }
  }
  const size_t n = lines.size();
  for (size_t k = 0; k < n; ++k) lines.push_back({-lines[k].normal, lines[k].area_mm2});
  return lines;
}

}  // namespace

std::vector<RotationCandidate> search_rotations(const PlaneSet& model, const PlaneSet& measured,
                                                size_t measured_directions, const SearchGates& gates) {
  const std::vector<PlaneDirection> model_directions = both_senses(model, gates.is_unsigned);
  const auto& seen = measured.directions;
  const size_t count = std::min(measured_directions, seen.size());
  DirectionScore score(model_directions, measured, gates.angle_rad);

  std::vector<RotationCandidate> raw;
  const auto propose = [&](const Mat3& R) {
    if (!holds_fixed(model, measured, {R, Vec3::Zero()}, gates, false)) return;
    raw.push_back({R, score.explained(R, 1.5 * gates.angle_rad, nullptr)});
  };
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = i + 1; k < count; ++k) {
      const double angle = angle_between(seen[i].normal, seen[k].normal);
      if (std::sin(angle) < kLeastSine) continue;
      for (const PlaneDirection& p : model_directions) {
        for (const PlaneDirection& q : model_directions) {
          const double model_angle = angle_between(p.normal, q.normal);
          if (std::sin(model_angle) < kLeastSine || std::abs(angle - model_angle) > gates.angle_rad) continue;
          propose(rotation_from_pair(seen[i].normal, seen[k].normal, p.normal, q.normal));
        }
      }
    }
  }
  if (raw.empty())
    for (size_t i = 0; i < count; ++i)
      for (const PlaneDirection& p : model_directions)
        propose(Eigen::Quaterniond::FromTwoVectors(seen[i].normal, p.normal).toRotationMatrix());

  std::stable_sort(raw.begin(), raw.end(),
                   [](const auto& a, const auto& b) { return a.explained > b.explained; });
  std::vector<RotationCandidate> kept;
  const double same_trace = 1 + 2 * std::cos(0.6 * gates.angle_rad);
  const auto known = [&](const Mat3& R) {
    return std::any_of(kept.begin(), kept.end(), [&](const RotationCandidate& other) {
      return other.R.cwiseProduct(R).sum() > same_trace;
    });
  };
  for (const RotationCandidate& candidate : raw) {
    if (kept.size() >= kMostRotations) break;
    if (known(candidate.R)) continue;
    const RotationCandidate refined = score.refined(candidate.R);
    if (!known(refined.R)) kept.push_back(refined);
  }
  std::stable_sort(kept.begin(), kept.end(),
                   [](const auto& a, const auto& b) { return a.explained > b.explained; });
  return kept;
}

}  // namespace tetragauge
