// SPDX-License-Identifier: GPL-3.0-or-later
#include <numbers>

#include "host/report/json_values.hpp"
#include "host/report/report.hpp"

namespace tetragauge {

using nlohmann::ordered_json;

ordered_json match_json(const Match& match, const std::string& method) {
  const RigidTransform& T = match.T_model_part;
  ordered_json json;
  json["method"] = method;
  json["pose"] = {{"rotation", json_matrix(T.R)},
                  {"translation_mm", json_matrix(T.t)},
                  {"covariance", json_matrix(match.covariance)},
                  {"centroid_mm", json_matrix(match.centroid_mm)},
                  {"rms_mm", json_number(match.rms_mm)}};
  const Vec3 deg = degrees_from_rotation(T.R);
  const Eigen::AngleAxisd turn(T.R);
  json["rotation_deg"] = {{"x", json_number(deg.x())},
                          {"y", json_number(deg.y())},
                          {"z", json_number(deg.z())},
                          {"axis", json_matrix(turn.axis())},
                          {"angle", json_number(turn.angle() * 180 / std::numbers::pi)}};
  json["equivalents"] = ordered_json::array();
  for (const EquivalentPose& other : match.equivalents) {
    json["equivalents"].push_back({{"rotation", json_matrix(other.T_model_part.R)},
                                   {"translation_mm", json_matrix(other.T_model_part.t)},
                                   {"why", other.why}});
  }
  json["undetermined"] = ordered_json::array();
  for (const FreeDirection& free : match.undetermined) {
    const bool shift = free.kind == FreeDirection::Kind::translation;
    json["undetermined"].push_back({{"kind", shift ? "translation" : "rotation"},
                                    {"axis", json_matrix(free.axis)},
                                    {"point_mm", json_matrix(free.point_mm)}});
  }
  json["pairs"] = ordered_json::array();
  for (const FacePair& pair : match.pairs) {
    json["pairs"].push_back({{"model", pair.model},
                             {"measured", pair.measured},
                             {"offset_mm", json_number(pair.offset_mm)},
                             {"angle_mrad", json_number(1e3 * pair.angle_rad)},
                             {"used_in_pose", pair.used_in_pose}});
  }
  json["unmatched_model"] = match.unmatched_model;
  json["unmatched_measured"] = match.unmatched_measured;
  return json;
}

}  // namespace tetragauge
