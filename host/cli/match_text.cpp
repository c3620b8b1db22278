// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/match_text.hpp"

#include <array>
#include <cstdio>
#include <numbers>

#include "host/match/turn_text.hpp"

namespace tetragauge::cli {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

std::string text(const char* format, auto... values) {
  std::array<char, 300> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

std::string list(const char* what, const std::vector<int>& ids) {
  if (ids.empty()) return {};
  std::string line = what;
  for (const int id : ids) line += " " + std::to_string(id);
  return line + "\n";
}

std::string pairs(const char* what, const std::vector<FaceIds>& ids) {
  if (ids.empty()) return {};
  std::string line = what;
  for (const FaceIds& pair : ids) line += text(" %d-%d", pair.model, pair.measured);
  return line + "\n";
}

std::string free_text(const FreeDirection& free) {
  return (free.kind == FreeDirection::Kind::translation ? "translation along " : "rotation about ") +
         vector_text(free.axis, 4) + "\n";
}

// The three turns in the order of the thesis, then the one turn about an axis.
std::string turns(const Mat3& R) {
  const Vec3 deg = degrees_from_rotation(R);
  const Eigen::AngleAxisd turn(R);
  return "Rz(" + number_text(deg.z(), 4) + ") Ry(" + number_text(deg.y(), 4) + ") Rx(" +
         number_text(deg.x(), 4) + ") degrees: " + number_text(turn.angle() * kDegrees, 4) + " about " +
         vector_text(turn.axis(), 4);
}

}  // namespace

std::string match_text(const Match& match) {
  const Vec3& t = match.T_model_part.t;
  std::string out = "pose (model from part): " + turns(match.T_model_part.R) + "\n";
  out += text("  t = %.4f %.4f %.4f mm, rms %.4f mm\n", t.x(), t.y(), t.z(), match.rms_mm);
  out += "model measured   offset mm  angle mrad\n";
  for (const FacePair& pair : match.pairs)
    out += text("%5d %8d %11.4f %11.3f%s\n", pair.model, pair.measured, pair.offset_mm, 1e3 * pair.angle_rad,
                pair.used_in_pose ? "" : "  out of place");
  out += list("model faces without a measured one:", match.unmatched_model);
  out += list("measured faces without a model one:", match.unmatched_measured);
  for (const MisplacedFeature& feature : match.misplaced) {
    out += pairs("misplaced, right shape (model-measured):", feature.pairs);
    out += text("  moved by %.4f %.4f %.4f mm, turned by %.4f degrees\n", feature.shift_mm.x(),
                feature.shift_mm.y(), feature.shift_mm.z(), feature.turn_rad * kDegrees);
  }
  if (!match.equivalents.empty())
    out += std::to_string(match.equivalents.size()) +
           " more poses that the data cannot tell apart, the first: " + match.equivalents.front().why + "\n";
  for (const RuledOutPose& other : match.ruled_out) out += "ruled out: " + other.why + "\n";
  for (const FreeDirection& free : match.undetermined) out += "undetermined: " + free_text(free);
  return out;
}

std::string procrustes_text(const ProcrustesMatch& procrustes) {
  const Vec3 difference = procrustes.plane_centre_measured_mm - procrustes.plane_centre_model_mm;
  std::string out = match_text(procrustes.match);
  out += text("plane centres, measured minus model: %.4f %.4f %.4f mm\n", difference.x(), difference.y(),
              difference.z());
  const char* const tried[] = {"no half turn", "half a turn about x", "half a turn about y",
                               "half a turn about z"};
  out += text("residual %.5f, with %s after the links by radius\n", procrustes.residual,
              tried[procrustes.half_turn_axis]);
  return out;
}

std::string pair_changes_text(const PairChanges& changes) {
  if (changes.made.empty() && changes.broken.empty())
    return "the fixed and forbidden pairs changed no pair\n";
  std::string out = pairs("pairs made by the rules (model-measured):", changes.made) +
                    pairs("pairs broken by the rules (model-measured):", changes.broken);
  out += text("  the part moved by %.4f %.4f %.4f mm and turned by %.4f degrees\n", changes.shift_mm.x(),
              changes.shift_mm.y(), changes.shift_mm.z(), changes.turn_rad * kDegrees);
  return out;
}

}  // namespace tetragauge::cli
