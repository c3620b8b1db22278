// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/measure/points_to_decide.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

// More than so many times the points is not worth the time.
constexpr double kLeastTimesPoints = 3, kMostTimesPoints = 20;
// U squared must be so much larger than what more points leave of it.
constexpr double kOwnShare = 1.3;
// A face whose tilt is so much better known than the other's adds nothing worth measuring.
constexpr double kWorthwhileVariance = 0.1;
constexpr double kParallelCosine = 1 - 1e-8;

// What a criterion's U is made of: the points of two faces, or of one and the pose.
struct MadeOf {
  const Datum* datum = nullptr;  // its points count too
  double floor = 0;              // of U squared: what ever more points leave
};

MadeOf made_of(const Criterion& criterion, const Face& nominal, const FaceInspection& face,
               const Tolerances& tolerances, double u_cal_mm) {
  const double u2_cal = u_cal_mm * u_cal_mm;
  if (const Datum* datum = criterion.datum.empty() ? nullptr : tolerances.datum(criterion.datum)) {
    // Orientations are free of the machine's share, which shifts a face and does not turn it.
    if (criterion.name != "position") return {datum, 0};
    const bool is_parallel =
        nominal.type == SurfaceType::plane && std::abs(nominal.normal.dot(datum->normal)) >= kParallelCosine;
    if (is_parallel) return {datum, 4 * 2 * u2_cal};
  }
  // The machine's and the pose's share, which an offset has alone.
  const double of_offset =
      0.25 * face.U_offset_mm * face.U_offset_mm - face.u_offset_own_mm * face.u_offset_own_mm + u2_cal;
  return {nullptr, 4 * std::max(0.0, of_offset)};
}

// By what the points must be multiplied to decide the criterion.
std::optional<double> times_points(const Criterion& criterion, double floor) {
  const double distance = std::abs(std::abs(criterion.deviation) - criterion.limit);
  const double now = criterion.U * criterion.U;
  // Undecided for another reason than its U, such as a datum that was not measured.
  if (criterion.verdict != Verdict::undecided || distance > criterion.U || now < kOwnShare * floor)
    return std::nullopt;
  // The deviation that is so near its limit is itself mostly noise: it moves too, and need not be where it
  // is.
  const double wanted = std::max(distance * distance, kOwnShare * floor);
  return std::clamp((now - floor) / std::max(1e-12, wanted - floor), kLeastTimesPoints, kMostTimesPoints);
}

double tilt_variance(const FaceInspection& face) {
  if (face.plane) return face.plane->covariance.matrix.bottomRightCorner<2, 2>().trace();
  return face.curve ? face.curve->covariance.topLeftCorner<3, 3>().trace() : 0;
}

}  // namespace

std::map<int, double> points_to_decide(const Inspection& inspection, const Solid& model,
                                       const Tolerances& tolerances, double u_cal_mm) {
  std::map<int, double> times;
  const auto want = [&](int id, double more) { times[id] = std::max(times[id], more); };
  for (const FaceInspection& face : inspection.faces) {
    if (face.verdict != Verdict::undecided || !face.decided_by) continue;
    const Face& nominal = model.faces()[static_cast<size_t>(face.model_id) - 1];
    const MadeOf parts = made_of(*face.decided_by, nominal, face, tolerances, u_cal_mm);
    const std::optional<double> more = times_points(*face.decided_by, parts.floor);
    if (!more) continue;
    if (!parts.datum) {
      want(face.model_id, *more);
      continue;
    }
    const FaceInspection& datum = inspection.faces[static_cast<size_t>(parts.datum->face) - 1];
    // In a position the datum's tilt counts as often as the face lies away from it.
    const bool is_position = face.decided_by->name == "position";
    const double own = tilt_variance(face), of_datum = tilt_variance(datum);
    if (is_position || own >= kWorthwhileVariance * of_datum) want(face.model_id, *more);
    if (is_position || of_datum >= kWorthwhileVariance * own) want(datum.model_id, *more);
  }
  return times;
}

}  // namespace tetragauge
