// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/part_pose.hpp"

namespace tetragauge {

PartPose best_fit(const std::vector<SetUp>& set_ups) {
  PartPose pose;
  pose.pivot_mm = set_ups.front().match.centroid_mm;
  for (const SetUp& set_up : set_ups) pose.covariances.push_back(set_up.match.covariance);
  return pose;
}

// Linear propagation (JCGM 100:2008, 5.1): a face's deviation feels the errors of the poses that its points
// were measured in, and the motion that the datums make, which rests on the datums' own points and on the
// errors of the poses that these were measured in. Where face and datum come from one set-up, its pose's
// error drops out along all that the datums hold.
PoseError PartPose::error(const std::vector<double>& share, int face) const {
  PoseError out;
  out.pivot_mm = pivot_mm;
  for (size_t s = 0; s < covariances.size(); ++s) {
    Mat6 from_pose = share[s] * Mat6::Identity();
    for (const Influence& datum : datums) from_pose += datum.share[s] * datum.from_pose;
    out.covariance += from_pose * covariances[s] * from_pose.transpose();
  }
  for (const Influence& datum : datums) {
    if (datum.face == face) {
      out.own_gain = datum.gain;
    } else {
      out.covariance += datum.gain * datum.covariance * datum.gain.transpose();
    }
  }
  return out;
}

}  // namespace tetragauge
