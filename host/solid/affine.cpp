// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/affine.hpp"

#include <Eigen/SVD>
#include <cmath>

namespace tetragauge {
namespace {

// Entries printed with six digits are off by at most 5e-7 of the largest one; a column of three by 9e-7, and
// scale and skew of the whole by a few times that.
constexpr double kSixDigits = 4e-6;
constexpr double kFullDigits = 1e-12;

// How far A is from a similarity, relative to its scale.
double skew(const Mat3& A) {
  const Mat3 G = A.transpose() * A;
  const double square = G.trace() / 3;
  return (G / square - Mat3::Identity()).cwiseAbs().maxCoeff();
}

gp_Trsf to_trsf(const Mat3& A, const Vec3& t) {
  gp_Trsf T;
  T.SetValues(A(0, 0), A(0, 1), A(0, 2), t.x(), A(1, 0), A(1, 1), A(1, 2), t.y(), A(2, 0), A(2, 1), A(2, 2),
              t.z());
  return T;
}

}  // namespace

Affine restore_digits(const Affine& printed) {
  if (!(std::abs(printed.A.determinant()) > 0)) return printed;
  const double off = skew(printed.A);
  const double scale = std::cbrt(std::abs(printed.A.determinant()));
  const bool is_unit = std::abs(scale - 1) < kSixDigits;
  if (off > kSixDigits || (off < kFullDigits && (!is_unit || std::abs(scale - 1) < kFullDigits))) {
    return printed;
  }
  // The nearest orthonormal matrix (Higham, SIAM J. Sci. Stat. Comput. 7 (1986) 1160).
  const Eigen::JacobiSVD<Mat3> svd(printed.A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {(is_unit ? 1.0 : scale) * svd.matrixU() * svd.matrixV().transpose(), printed.t};
}

std::optional<gp_Trsf> similarity(const Affine& M) {
  if (!(std::abs(M.A.determinant()) > 0) || skew(M.A) > 1e-9) return std::nullopt;
  return to_trsf(M.A, M.t);
}

std::optional<AxialScale> axial_scale(const Affine& M) {
  const double across = 0.5 * (M.A.col(0).norm() + M.A.col(1).norm());
  const double along = M.A.col(2).norm();
  if (!(across > 0) || !(along > 0)) return std::nullopt;
  Affine S = M;
  S.A.col(2) *= across / along;
  const std::optional<gp_Trsf> T = similarity(S);
  if (!T) return std::nullopt;
  return AxialScale{*T, along / across};
}

}  // namespace tetragauge
