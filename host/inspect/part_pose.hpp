// SPDX-License-Identifier: GPL-3.0-or-later
// How the errors of the poses, and of the datums that they rest on, enter the deviations of each face.
#pragma once

#include <algorithm>
#include <vector>

#include "host/inspect/inspect.hpp"

namespace tetragauge {

using Row6 = Eigen::Matrix<double, 1, 6>;
using Mat36 = Eigen::Matrix<double, 3, 6>;
using Mat63 = Eigen::Matrix<double, 6, 3>;

// What a turn and shift of the part at `pivot` (rx ry rz tx ty tz) add to the offset along n at p.
inline Row6 offset_row(const Vec3& p, const Vec3& n, const Vec3& pivot) {
  Row6 row;
  row << (p - pivot).cross(n).transpose(), n.transpose();
  return row;
}

// What they add to the tilts about u and v.
inline Eigen::Matrix<double, 2, 6> tilt_rows(const Vec3& u, const Vec3& v) {
  Eigen::Matrix<double, 2, 6> rows = Eigen::Matrix<double, 2, 6>::Zero();
  rows.topLeftCorner<1, 3>() = u.transpose();
  rows.bottomLeftCorner<1, 3>() = v.transpose();
  return rows;
}

// For one face.
struct PoseError {
  Vec3 pivot_mm = Vec3::Zero();    // model frame
  Mat6 covariance = Mat6::Zero();  // rx ry rz tx ty tz there, of all that is not this face's own points
  Mat63 own_gain = Mat63::Zero();  // a datum's own offset and tilts move the part by so much
};

struct PartPose {
  Vec3 pivot_mm = Vec3::Zero();
  std::vector<Mat6> covariances;  // of each set-up's best fit

  // A datum's part in the motion that takes the best fit to the datums.
  struct Influence {
    int face = 0;
    std::vector<double> share;       // of each set-up in its points
    Mat63 gain = Mat63::Zero();      // from its offset and tilts
    Mat6 from_pose = Mat6::Zero();   // from an error of the pose that it was measured in
    Mat3 covariance = Mat3::Zero();  // of its offset and tilts
  };
  std::vector<Influence> datums;  // empty: best fit

  // `share`: of each set-up in the points of the face; its sum is 1. `face`: its model id, 0 for none.
  PoseError error(const std::vector<double>& share, int face) const;
};

PartPose best_fit(const std::vector<SetUp>& set_ups);

}  // namespace tetragauge
