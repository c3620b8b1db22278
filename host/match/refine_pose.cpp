// SPDX-License-Identifier: GPL-3.0-or-later
// Truncated least squares by graduated non-convexity (Yang et al., IEEE RA-L 5 (2020) 1127, eq. 12-14):
// starts convex, where every face has a say, and ends where a face out of place has none. Plain least squares
// would spread one face's 0.4 mm over all the others.
#include "host/match/refine_pose.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetragauge {
namespace {

constexpr double kChi2_3_999 = 16.27;  // 99.9 % of chi-square with 3 degrees of freedom: offset and two tilts
constexpr double kChi2_1_median = 0.4549;
constexpr double kPriorFreedom = 4;
constexpr double kBounds = 0.05;  // cosine between its normal and a direction that a face bounds

using Rows = Eigen::Matrix<double, 3, 6>;

struct Linear {
  Vec3 residual;
  Rows jacobian;
};

// delta = (turn about the pivot, shift), applied from the left in the model frame.
Linear linearise(const PlaneObservation& seen, const RigidTransform& T, const Vec3& pivot) {
  Linear out;
  out.residual = plane_residual(seen, T);
  const Vec3 arm = T * seen.point_mm - pivot;
  const Vec3 u = T.R * seen.covariance.u, v = T.R * seen.covariance.v;
  out.jacobian << arm.cross(seen.model_normal).transpose(), seen.model_normal.transpose(),  //
      u.transpose(), Eigen::RowVector3d::Zero(),                                            //
      v.transpose(), Eigen::RowVector3d::Zero();
  return out;
}

Mat3 information(const PlaneObservation& seen, double scatter_mm, double scatter_rad) {
  Mat3 covariance = seen.covariance.matrix;
  covariance(0, 0) += scatter_mm * scatter_mm;
  covariance(1, 1) += scatter_rad * scatter_rad;
  covariance(2, 2) += scatter_rad * scatter_rad;
  return covariance.inverse();
}

RigidTransform moved(const RigidTransform& T, const Vec6& step, const Vec3& pivot) {
  const Vec3 turn = step.head<3>();
  const double angle = turn.norm();
  const Mat3 R = angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Mat3::Identity();
  return RigidTransform{R, pivot + step.tail<3>() - R * pivot} * T;
}

class Fit {
 public:
  Fit(const std::vector<PlaneObservation>& seen, const RigidTransform& start, const Vec3& pivot, double size,
      const ScatterPrior& prior)
      : seen_(seen), pivot_(pivot), size_mm_(size), prior_(prior), weight_(seen.size(), 1.0) {
    result_.T_model_part = start;
    double smallest_mm2 = 0, smallest_rad2 = 0;
    for (const PlaneObservation& o : seen) {
      smallest_mm2 += o.covariance.matrix(0, 0);
      smallest_rad2 += o.covariance.matrix(1, 1);
    }
    // Without uncertainties of their own the faces need some: a ten-thousandth of the part.
    const double floor = smallest_mm2 > 0 && smallest_rad2 > 0 ? 1e-7 : 1e-4;
    floor_mm_ = floor * size;
    floor_rad_ = 2 * floor;
  }

  RefinedPose run() {
    estimate_scatter(true);
    // Towards the least sum of deviations rather than of squares (by re-weighting), before anything is left
    // out: squares would spread a feature out of place over all faces, and then none of them stands out.
    for (int i = 0; i < 12; ++i) {
      for (size_t k = 0; k < seen_.size(); ++k) weight_[k] = 1 / std::sqrt(1 + 100 * cost(k));
      const double moved_mm = step();
      estimate_scatter(true);
      if (moved_mm < 0.01 * result_.scatter_mm) break;
    }
    for (int round = 0; round < 3; ++round) {
      graduate();
      share_what_cannot_be_told();
      const double before_mm = result_.scatter_mm, before_rad = result_.scatter_rad;
      estimate_scatter(false);
      if (std::abs(before_mm - result_.scatter_mm) < 0.05 * before_mm &&
          std::abs(before_rad - result_.scatter_rad) < 0.05 * before_rad)
        break;
    }
    for (int i = 0; i < 3; ++i) step();
    conclude();
    return std::move(result_);
  }

 private:
  double cost(size_t k) const {
    const Vec3 r = plane_residual(seen_[k], result_.T_model_part);
    return r.dot(information(seen_[k], result_.scatter_mm, result_.scatter_rad) * r);
  }

  Mat6 normal_equations(Vec6* right) const {
    Mat6 normal = Mat6::Zero();
    for (size_t k = 0; k < seen_.size(); ++k) {
      if (weight_[k] <= 0) continue;
      const Linear row = linearise(seen_[k], result_.T_model_part, pivot_);
      const Mat3 W = weight_[k] * information(seen_[k], result_.scatter_mm, result_.scatter_rad);
      normal += row.jacobian.transpose() * W * row.jacobian;
      if (right) *right -= row.jacobian.transpose() * W * row.residual;
    }
    return normal;
  }

  // Solves along the directions that the faces determine, and leaves the free ones alone. Turns are measured
  // by the arc they make on the part, so that the six are comparable.
  static Mat6 pseudo_inverse(const Mat6& normal, double arm_mm) {
    Vec6 unit;
    unit << Vec3::Constant(1 / arm_mm), Vec3::Ones();
    const Mat6 scaled = unit.asDiagonal() * normal * unit.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(scaled);
    Vec6 inverse = Vec6::Zero();
    for (int i = 0; i < 6; ++i)
      if (eigen.eigenvalues()[i] > 1e-10 * eigen.eigenvalues()[5]) inverse[i] = 1 / eigen.eigenvalues()[i];
    return unit.asDiagonal() *
           (eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose()) *
           unit.asDiagonal();
  }

  // The length of the step, as the arc it makes on the part.
  double step() {
    Vec6 right = Vec6::Zero();
    const Mat6 normal = normal_equations(&right);
    const double arm_mm = 0.3 * size_mm_;
    Vec6 unit;
    unit << Vec3::Constant(1 / arm_mm), Vec3::Ones();
    // Cholesky where all six are determined (in units in which they are comparable), for it is much faster.
    const Eigen::LLT<Mat6> cholesky(unit.asDiagonal() * normal * unit.asDiagonal());
    const bool determined = cholesky.info() == Eigen::Success && cholesky.rcond() > 1e-8;
    const Vec6 move = determined ? Vec6(unit.asDiagonal() * cholesky.solve(unit.asDiagonal() * right))
                                 : Vec6(pseudo_inverse(normal, arm_mm) * right);
    result_.T_model_part = moved(result_.T_model_part, move, pivot_);
    return arm_mm * move.head<3>().norm() + move.tail<3>().norm();
  }

  struct Deviation {
    double square, own_variance;
  };

  // Scatter of the faces beyond their own uncertainty: what must be added to their variances so that their
  // squared deviations are 1 on average. `robust`: judged by the median, with the small-sample factor of
  // Rousseeuw and Leroy, Robust Regression and Outlier Detection (1987), p. 202; otherwise over the faces
  // kept.
  void estimate_scatter(bool robust) {
    std::vector<Deviation> offsets, tilts;
    for (size_t k = 0; k < seen_.size(); ++k) {
      if (!robust && weight_[k] < 0.5) continue;
      const Vec3 r = plane_residual(seen_[k], result_.T_model_part);
      const Mat3& own = seen_[k].covariance.matrix;
      offsets.push_back({r[0] * r[0], own(0, 0)});
      // The mean of two squares has its median at ln 2 of a variance.
      tilts.push_back({0.5 * (r[1] * r[1] + r[2] * r[2]), 0.5 * (own(1, 1) + own(2, 2))});
    }
    result_.scatter_mm = scatter(offsets, robust, 3, kChi2_1_median, floor_mm_, prior_.mm, 6);
    result_.scatter_rad = scatter(tilts, robust, 1.5, std::log(2.0), floor_rad_, prior_.rad, 1.5);
  }

  static double scatter(const std::vector<Deviation>& deviations, bool robust, double parameters,
                        double median, double floor, double prior, double most_parameters) {
    const double freedom = static_cast<double>(deviations.size()) - parameters;
    // Offsets that six parameters can fit exactly say nothing about the scatter, and a fit that trusted them
    // so would turn the part to please them.
    const double known = static_cast<double>(deviations.size()) - most_parameters;
    const double believed = std::clamp((kPriorFreedom - known) / kPriorFreedom, 0.0, 1.0);
    floor = std::max(floor, prior * std::sqrt(believed));
    if (freedom < 0.5) return floor;
    std::vector<double> squares(deviations.size());
    const auto statistic = [&](double added) {
      for (size_t k = 0; k < squares.size(); ++k)
        squares[k] = deviations[k].square / (deviations[k].own_variance + added * added);
      if (!robust) return std::accumulate(squares.begin(), squares.end(), 0.0) / freedom;
      // The parameters can make as many residuals vanish: the median is taken of the others.
      const auto at =
          squares.begin() + static_cast<std::ptrdiff_t>(
                                std::min(static_cast<double>(squares.size() - 1), parameters + freedom / 2));
      std::nth_element(squares.begin(), at, squares.end());
      const double inflate = 1 + 5 / std::max(1.0, freedom);
      return inflate * inflate * *at / median;
    };
    // So much above 1 is chance in a handful of faces.
    if (statistic(floor) < 1 + 3 / std::sqrt(freedom)) return floor;
    double low = floor, high = 2 * floor;
    while (statistic(high) > 1) high *= 2;
    for (int i = 0; i < 40 && high - low > 1e-3 * low; ++i) {
      const double middle = 0.5 * (low + high);
      (statistic(middle) > 1 ? low : high) = middle;
    }
    return high;
  }

  void graduate() {
    std::fill(weight_.begin(), weight_.end(), 1.0);
    step();
    double largest = 0;
    for (size_t k = 0; k < seen_.size(); ++k) largest = std::max(largest, cost(k));
    if (largest <= kChi2_3_999) return;
    double mu = kChi2_3_999 / (2 * largest - kChi2_3_999);
    for (int i = 0; i < 100; ++i, mu *= 1.4) {
      bool hard = true;
      for (size_t k = 0; k < seen_.size(); ++k) {
        const double q = cost(k);
        if (q >= (mu + 1) / mu * kChi2_3_999) {
          weight_[k] = 0;
        } else if (q <= mu / (mu + 1) * kChi2_3_999) {
          weight_[k] = 1;
        } else {
          weight_[k] = std::sqrt(kChi2_3_999 / q * mu * (mu + 1)) - mu;
          hard = false;
        }
      }
      step();
      if (hard && mu > 1) break;
    }
    for (double& w : weight_) w = w > 0.5 ? 1 : 0;
    step();
  }

  // A direction that one kept face alone holds, or none, although left-out faces bound it too: their
  // distances are wrong, and nobody can say which of them moved. Then all of them share it, each as uncertain
  // as they disagree.
  void share_what_cannot_be_told() {
    std::vector<size_t> holders;  // faces to try without; seen_.size() stands for none
    for (size_t k = 0; k < seen_.size(); ++k)
      if (weight_[k] > 0) holders.push_back(k);
    holders.push_back(seen_.size());
    std::vector<double> shared = weight_;
    for (const size_t without : holders) {
      Mat3 normals = Mat3::Zero();
      for (size_t k = 0; k < seen_.size(); ++k)
        if (weight_[k] > 0 && k != without)
          normals += seen_[k].model_normal * seen_[k].model_normal.transpose();
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(normals);
      for (int axis = 0; axis < 3; ++axis)
        if (eigen.eigenvalues()[axis] < 1e-4) share_along(eigen.eigenvectors().col(axis), without, shared);
    }
    if (shared == weight_) return;
    weight_ = std::move(shared);
    for (int i = 0; i < 3; ++i) step();
  }

  void share_along(const Vec3& free, size_t holder, std::vector<double>& shared) const {
    std::vector<size_t> candidates;
    double low = 1e300, high = -1e300;  // where each would put the part along `free`
    for (size_t k = 0; k < seen_.size(); ++k) {
      const double cosine = seen_[k].model_normal.dot(free);
      if (std::abs(cosine) < kBounds || (weight_[k] > 0 && k != holder)) continue;
      const Vec3 r = plane_residual(seen_[k], result_.T_model_part);
      const Mat3 W = information(seen_[k], result_.scatter_mm, result_.scatter_rad);
      if (r[1] * r[1] * W(1, 1) + r[2] * r[2] * W(2, 2) > kChi2_3_999) continue;  // tilted: not the same face
      candidates.push_back(k);
      low = std::min(low, r[0] / cosine);
      high = std::max(high, r[0] / cosine);
    }
    if (candidates.size() < 2 || !(high > low)) {
      if (holder == seen_.size()) hold_loosely(free, shared);
      return;
    }
    for (const size_t k : candidates)
      shared[k] = 1 / ((high - low) * (high - low) *
                       information(seen_[k], result_.scatter_mm, result_.scatter_rad)(0, 0));
  }

  // Nothing that is kept bounds this direction, and a face that is tilted does: its middle still says about
  // where it is. It counts as far as it is believed, with its uncertainty widened to what it deviates (Birge,
  // Phys. Rev. 40 (1932) 207).
  void hold_loosely(const Vec3& free, std::vector<double>& shared) const {
    for (size_t k = 0; k < seen_.size(); ++k)
      if (std::abs(seen_[k].model_normal.dot(free)) >= kBounds && !(weight_[k] > 0))
        shared[k] = std::min(1.0, 3 / cost(k));
  }

  void conclude() {
    result_.covariance = pseudo_inverse(normal_equations(nullptr), 0.3 * size_mm_);
    double sum = 0, count = 0;
    result_.used.resize(seen_.size());
    for (size_t k = 0; k < seen_.size(); ++k) {
      result_.used[k] = weight_[k] > 0;
      if (weight_[k] < 0.5) continue;
      const double offset = plane_residual(seen_[k], result_.T_model_part)[0];
      sum += offset * offset;
      ++count;
    }
    result_.rms_mm = count > 0 ? std::sqrt(sum / count) : 0;
  }

  const std::vector<PlaneObservation>& seen_;
  Vec3 pivot_;
  double size_mm_;
  ScatterPrior prior_;
  double floor_mm_ = 0, floor_rad_ = 0;
  std::vector<double> weight_;
  RefinedPose result_;
};

}  // namespace

Vec3 plane_residual(const PlaneObservation& seen, const RigidTransform& T) {
  const double offset = seen.model_normal.dot(T * seen.point_mm) - seen.model_d_mm;
  const Vec3 u = T.R * seen.covariance.u, v = T.R * seen.covariance.v;
  // A turn by w takes the model's normal to the measured one, m = n + w x n; so w . u = n . v, w . v = -n .
  // u.
  return {offset, seen.model_normal.dot(v), -seen.model_normal.dot(u)};
}

PlaneObservation observe(const MatchPlane& model, const MatchPlane& measured, bool flipped) {
  PlaneObservation out;
  out.model_normal = model.normal;
  out.model_d_mm = model.d_mm;
  out.point_mm = measured.point_mm;
  out.covariance = measured.covariance;
  const bool opposite = out.covariance.u.cross(out.covariance.v).dot(measured.normal) < 0;
  if (flipped !=
      opposite) {  // v turns with the normal, and with it the signs of offset and of the tilt about v
    out.covariance.v = -out.covariance.v;
    const Vec3 sign(-1, 1, -1);
    out.covariance.matrix = sign.asDiagonal() * out.covariance.matrix * sign.asDiagonal();
  }
  return out;
}

RefinedPose refine_pose(const std::vector<PlaneObservation>& observations, const RigidTransform& start,
                        const Vec3& pivot_mm, double size_mm, const ScatterPrior& prior) {
  return Fit(observations, start, pivot_mm, size_mm, prior).run();
}

}  // namespace tetragauge
