// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/hold_by_datums.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

using Eigen::MatrixXd;

constexpr size_t kHolding = 3;    // primary, secondary, tertiary; further ones are references alone
constexpr double kNoHold = 1e-6;  // of lengths of the part: far below is_parallel's milliradian
constexpr int kSteps = 3;         // linearised about parts in a thousand, each step squares the rest

// Of one datum, in the model frame: its plane as measured against its nominal one.
struct Seen {
  Vec3 residual;  // offset at the centroid of its points [mm], tilts about u and v [rad]
  Mat36 jacobian;
};

Seen see(const Face& nominal, const PlaneAsMeasured& plane, const RigidTransform& moved, const Vec3& pivot) {
  const Vec3 point = moved * plane.point_mm, normal = moved.R * plane.normal;
  const auto& [u, v] = std::pair{plane.covariance.u, plane.covariance.v};
  const Vec3 turn = nominal.normal.cross(normal);
  Seen seen;
  seen.residual << nominal.normal.dot(point) - nominal.d_mm, turn.dot(u), turn.dot(v);
  seen.jacobian << offset_row(point, nominal.normal, pivot), tilt_rows(u, v);
  return seen;
}

Mat6 in_lengths(double arm_mm) {  // turns by the arc they make on the part
  Vec6 unit;
  unit << Vec3::Constant(1 / arm_mm), Vec3::Ones();
  return unit.asDiagonal();
}

// Information where there is any, nothing along directions of which the match knows nothing.
Mat6 information(const Mat6& covariance, double arm_mm) {
  const Mat6 to_turns = in_lengths(arm_mm), to_lengths = to_turns.inverse();
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(to_lengths * covariance * to_lengths);
  Vec6 inverse = Vec6::Zero();
  for (int i = 0; i < 6; ++i)
    if (eigen.eigenvalues()[i] > 1e-12 * eigen.eigenvalues()[5]) inverse[i] = 1 / eigen.eigenvalues()[i];
  return to_lengths * (eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose()) *
         to_lengths;
}

// Solves N' W N y = right in the least-squares sense.
MatrixXd solve(const MatrixXd& normal, const MatrixXd& right) {
  return normal.completeOrthogonalDecomposition().solve(right);
}

// Of a basis of motions, how many turns it holds.
int rotations_in(const MatrixXd& basis, double arm_mm) {
  if (basis.cols() == 0) return 0;
  const Eigen::VectorXd turns = Eigen::JacobiSVD<MatrixXd>(arm_mm * basis.topRows(3)).singularValues();
  return static_cast<int>((turns.array() > kNoHold).count());
}

// The motion x that the datums ask for, as a linear function of what is seen of them.
struct Motion {
  Vec6 x = Vec6::Zero();
  std::vector<Mat63> gain;  // per datum
  std::vector<Alignment::Held> held;
};

Motion motion_to(const std::vector<Seen>& seen, const std::vector<Mat3>& covariances, const Mat6& prior,
                 double arm_mm) {
  Motion out;
  MatrixXd free = in_lengths(arm_mm);  // basis of the motions still free
  for (size_t k = 0; k < seen.size(); ++k) {
    const Mat36& J = seen[k].jacobian;
    // Tilts by the arc they make: all rows are lengths.
    MatrixXd on_free = J * free;
    on_free.bottomRows(2) *= arm_mm;
    Eigen::JacobiSVD<MatrixXd> svd(on_free, Eigen::ComputeFullV);
    svd.setThreshold(kNoHold);
    const Eigen::Index rank = svd.rank();
    const MatrixXd holding = free * svd.matrixV().leftCols(rank);
    const Mat3 weight = covariances[k].inverse();
    const MatrixXd across = J * holding;
    const Mat63 step = holding * solve(across.transpose() * weight * across, across.transpose() * weight);
    const Mat6 rest = Mat6::Identity() - step * J;
    for (Mat63& gain : out.gain) gain = rest * gain;
    out.gain.push_back(-step);
    out.x = rest * out.x - step * seen[k].residual;

    const MatrixXd still_free = free * svd.matrixV().rightCols(free.cols() - rank);
    const int rotations = rotations_in(free, arm_mm) - rotations_in(still_free, arm_mm);
    out.held.push_back({"", 0, rotations, static_cast<int>(rank) - rotations});
    free = still_free;
  }
  if (free.cols() > 0) {
    const Mat6 step = free * solve(free.transpose() * prior * free, free.transpose() * prior);
    out.x -= step * out.x;
    for (Mat63& gain : out.gain) gain -= step * gain;
  }
  return out;
}

RigidTransform small_motion(const Vec6& x, const Vec3& pivot) {
  const Vec3 turn = x.head<3>();
  const double angle = turn.norm();
  const Mat3 R = angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Mat3::Identity();
  return {R, pivot + x.tail<3>() - R * pivot};
}

// The pairs as they lie in the new pose.
void place_pairs(const Solid& model, SetUp& set_up) {
  const RigidTransform& T = set_up.match.T_model_part;
  for (FacePair& pair : set_up.match.pairs) {
    const Face& nominal = model.faces()[static_cast<size_t>(pair.model) - 1];
    const Face& face = set_up.measured.faces()[static_cast<size_t>(pair.measured) - 1];
    if (nominal.type != SurfaceType::plane || face.type != SurfaceType::plane) continue;
    const Vec3 normal = T.R * face.normal;
    pair.offset_mm = normal.dot(T * face.point_mm - nominal.point_mm) / normal.dot(nominal.normal);
    pair.angle_rad = std::atan2(normal.cross(nominal.normal).norm(), normal.dot(nominal.normal));
  }
}

}  // namespace

void hold_by_datums(const Solid& model, const std::vector<Datum>& datums,
                    const std::vector<FaceInspection>& faces, const std::vector<std::vector<double>>& share,
                    std::vector<SetUp>& set_ups, PartPose& pose, Alignment& alignment) {
  const size_t count = std::min(kHolding, datums.size());
  std::vector<Mat3> covariances;
  for (size_t k = 0; k < count; ++k) {
    const FaceInspection& face = faces[static_cast<size_t>(datums[k].face) - 1];
    if (!face.measured || !face.plane) {
      alignment.problem = "datum " + datums[k].name + " (face " + std::to_string(datums[k].face) +
                          ") was not measured" + (face.reason.empty() ? "" : " (" + face.reason + ")");
      return;
    }
    covariances.push_back(face.plane->covariance.matrix);
  }
  Mat6 prior = Mat6::Zero();
  const double arm_mm = 0.5 * (model.box_max_mm - model.box_min_mm).norm();
  for (const Mat6& covariance : pose.covariances) prior += information(covariance, arm_mm);

  RigidTransform moved;
  Motion motion;
  std::vector<Seen> seen;
  for (int step = 0; step < kSteps; ++step) {
    seen.clear();
    for (size_t k = 0; k < count; ++k) {
      const size_t face = static_cast<size_t>(datums[k].face) - 1;
      seen.push_back(see(model.faces()[face], *faces[face].plane, moved, pose.pivot_mm));
    }
    motion = motion_to(seen, covariances, prior, arm_mm);
    moved = small_motion(motion.x, pose.pivot_mm) * moved;
  }
  for (size_t k = 0; k < count; ++k) {
    motion.held[k].datum = datums[k].name;
    motion.held[k].face = datums[k].face;
    pose.datums.push_back({datums[k].face, share[static_cast<size_t>(datums[k].face) - 1], motion.gain[k],
                           motion.gain[k] * seen[k].jacobian, covariances[k]});
  }
  alignment.datums = motion.held;
  for (size_t s = 0; s < set_ups.size(); ++s) {
    set_ups[s].match.T_model_part = moved * set_ups[s].match.T_model_part;
    std::vector<double> here(set_ups.size(), 0.0);
    here[s] = 1;
    set_ups[s].match.covariance = pose.error(here, 0).covariance;
    for (MisplacedFeature& feature : set_ups[s].match.misplaced)
      feature.T_model_part = moved * feature.T_model_part;
    place_pairs(model, set_ups[s]);
  }
}

}  // namespace tetragauge
