// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/against_datum.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "host/inspect/applies_to.hpp"
#include "host/inspect/plane_deviation.hpp"

namespace tetragauge {
namespace {

// A small turn with its covariance, rad.
struct Turn {
  Vec3 value = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();

  double U() const {
    const double largest = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvalues()[2];
    return 2 * std::sqrt(std::max(0.0, largest));
  }
};

Turn turn_of(const FaceInspection& measured, const Vec3& direction) {
  if (measured.plane) return {tilt_of(*measured.plane, direction), tilt_covariance(*measured.plane)};
  const Mat3 across = Mat3::Identity() - direction * direction.transpose();
  return {across * measured.curve->motion.head<3>(),
          across * measured.curve->covariance.topLeftCorner<3, 3>() * across};
}

// The turn of the face that the datum can notice: the part may turn about the datum's normal.
Turn turn_against_datum(const FaceAgainstDatum& in, const Vec3& direction) {
  const Turn own = turn_of(in.measured, direction), datum = turn_of(in.datum_measured, in.datum.normal);
  Turn turn{own.value - datum.value, own.covariance + datum.covariance};
  if (is_parallel(direction, in.datum.normal)) return turn;
  const Vec3 hinge = in.datum.normal.cross(direction).normalized();
  const Mat3 on_hinge = hinge * hinge.transpose();
  return {on_hinge * turn.value, on_hinge * turn.covariance * on_hinge};
}

Criterion angularity(const FaceAgainstDatum& in, const Vec3& direction) {
  const Turn turn = turn_against_datum(in, direction);
  double signed_rad = turn.value.norm();
  // Where it is one angle that is wrong it has a sign: + opens the angle between the two directions.
  if (!is_parallel(direction, in.datum.normal) && turn.value.dot(in.datum.normal.cross(direction)) < 0)
    signed_rad = -signed_rad;
  return {"", 1e3 * signed_rad, 1e3 * turn.U(), 0, Verdict::none, ""};
}

// Width of the zone that the turned face needs: a plane with its form, an axis as a line.
Criterion zone(const FaceAgainstDatum& in, const Vec3& direction) {
  const Turn turn = turn_against_datum(in, direction);
  double low = 1e300, high = -1e300, radius = 0;
  for (const Vec3& corner : in.outline.corners) {
    const Vec3 r = corner - in.face.point_mm;
    // An axis is as long as its face.
    const double height = in.measured.plane ? direction.dot(turn.value.cross(r)) : direction.dot(r);
    low = std::min(low, height);
    high = std::max(high, height);
    radius = std::max(radius, r.norm());
  }
  if (!in.measured.plane)
    return {"", turn.value.norm() * (high - low), turn.U() * (high - low), 0, Verdict::none, ""};
  return {"",
          high - low + in.measured.form_mm,
          std::hypot(turn.U() * 2 * radius, in.measured.U_form_mm),
          0,
          Verdict::none,
          ""};
}

Criterion position(const FaceAgainstDatum& in) {
  if (in.measured.curve)
    return {"", in.measured.position_mm.value_or(0), in.measured.U_position_mm, 0, Verdict::none, ""};
  if (!is_parallel(in.face.normal, in.datum.normal))
    return {"", in.measured.profile_mm, in.measured.U_profile_mm, 0, Verdict::none, ""};
  const PlaneAsMeasured &plane = *in.measured.plane, &datum = *in.datum_measured.plane;
  const double side = in.face.normal.dot(in.datum.normal) > 0 ? 1 : -1;
  Criterion out;
  for (const Vec3& corner : in.outline.corners) {
    const Vec3 on_datum = corner - in.datum.normal * (in.datum.normal.dot(corner) - in.datum.d_mm);
    const double off =
        height(plane, in.face.normal, corner) - side * height(datum, in.datum.normal, on_datum);
    const double u2 = own_height_variance(plane, corner) + own_height_variance(datum, on_datum);
    const double deviation = std::abs(off) + 0.5 * in.measured.form_mm;
    const double U = std::hypot(2 * std::sqrt(u2), 0.5 * in.measured.U_form_mm);
    if (deviation + U <= std::abs(out.deviation) + out.U) continue;
    out.deviation = std::copysign(deviation, off);
    out.U = U;
  }
  return out;
}

}  // namespace

std::optional<Criterion> against_datum(std::string_view key, const FaceAgainstDatum& in) {
  if (!in.measured.measured || !in.datum_measured.measured || !in.datum_measured.plane) return std::nullopt;
  if (!in.measured.plane && !in.measured.curve) return std::nullopt;
  const Vec3& direction = in.measured.plane ? in.face.normal : in.face.axis;
  if (key == "position_mm") return position(in);
  if (key == "angularity_mrad") return angularity(in, direction);
  return zone(in, direction);
}

}  // namespace tetragauge
