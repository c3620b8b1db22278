// SPDX-License-Identifier: GPL-3.0-or-later
#include <numbers>

#include "host/report/json_values.hpp"
#include "host/report/report.hpp"

namespace tetragauge {

using nlohmann::ordered_json;

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

ordered_json ids_json(const std::vector<FaceIds>& pairs) {
  ordered_json json = ordered_json::array();
  for (const FaceIds& pair : pairs) json.push_back({{"model", pair.model}, {"measured", pair.measured}});
  return json;
}

ordered_json free_json(const std::vector<FreeDirection>& directions) {
  ordered_json json = ordered_json::array();
  for (const FreeDirection& free : directions) {
    const bool shift = free.kind == FreeDirection::Kind::translation;
    json.push_back({{"kind", shift ? "translation" : "rotation"},
                    {"axis", json_matrix(free.axis)},
                    {"point_mm", json_matrix(free.point_mm)}});
  }
  return json;
}

ordered_json rotation_json(const Mat3& R) {
  const Vec3 deg = degrees_from_rotation(R);
  const Eigen::AngleAxisd turn(R);
  return {{"x", json_number(deg.x())},
          {"y", json_number(deg.y())},
          {"z", json_number(deg.z())},
          {"axis", json_matrix(turn.axis())},
          {"angle", json_number(turn.angle() * kDegrees)}};
}

ordered_json misplaced_json(const MisplacedFeature& feature) {
  ordered_json json;
  json["faces"] = ordered_json::array();
  for (const FaceIds& pair : feature.pairs)
    if (json["faces"].empty() || json["faces"].back() != pair.model) json["faces"].push_back(pair.model);
  json["pairs"] = ids_json(feature.pairs);
  json["pose"] = {{"rotation", json_matrix(feature.T_model_part.R)},
                  {"translation_mm", json_matrix(feature.T_model_part.t)}};
  json["shift_mm"] = json_matrix(feature.shift_mm);
  json["turn_deg"] = json_number(feature.turn_rad * kDegrees);
  json["undetermined"] = free_json(feature.undetermined);
  return json;
}

}  // namespace

ordered_json match_json(const Match& match, const std::string& method) {
  const RigidTransform& T = match.T_model_part;
  ordered_json json;
  json["method"] = method;
  const bool by_surface = match.found_by == MatchedBy::surface;
  json["found_by"] = by_surface ? "surface" : "planes";
  if (by_surface) {
    json["surface_fit"] = {{"why", match.surface_fit.why},
                           {"scatter_mm", json_number(match.surface_fit.scatter_mm)},
                           {"explained", json_number(match.surface_fit.explained)}};
  }
  json["pose"] = {{"rotation", json_matrix(T.R)},
                  {"translation_mm", json_matrix(T.t)},
                  {"covariance", json_matrix(match.covariance)},
                  {"centroid_mm", json_matrix(match.centroid_mm)},
                  {"rms_mm", json_number(match.rms_mm)}};
  json["rotation_deg"] = rotation_json(T.R);
  json["equivalents"] = ordered_json::array();
  for (const EquivalentPose& other : match.equivalents) {
    json["equivalents"].push_back({{"rotation", json_matrix(other.T_model_part.R)},
                                   {"translation_mm", json_matrix(other.T_model_part.t)},
                                   {"why", other.why},
                                   {"undetermined", free_json(other.undetermined)}});
  }
  json["ruled_out"] = ordered_json::array();
  for (const RuledOutPose& other : match.ruled_out) {
    json["ruled_out"].push_back({{"rotation", json_matrix(other.T_model_part.R)},
                                 {"translation_mm", json_matrix(other.T_model_part.t)},
                                 {"faces", other.model_faces},
                                 {"why", other.why}});
  }
  json["undetermined"] = free_json(match.undetermined);
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
  json["misplaced"] = ordered_json::array();
  for (const MisplacedFeature& feature : match.misplaced)
    json["misplaced"].push_back(misplaced_json(feature));
  return json;
}

ordered_json procrustes_json(const ProcrustesMatch& procrustes) {
  ordered_json json = match_json(procrustes.match, "procrustes");
  json["pose"]["covariance"] = nullptr;  // the method knows none
  const Vec3 difference = procrustes.plane_centre_measured_mm - procrustes.plane_centre_model_mm;
  json["procrustes"] = {{"plane_centre_model_mm", json_matrix(procrustes.plane_centre_model_mm)},
                        {"plane_centre_measured_mm", json_matrix(procrustes.plane_centre_measured_mm)},
                        {"plane_centre_difference_mm", json_matrix(difference)},
                        {"half_turn_axis", procrustes.half_turn_axis},
                        {"residual", json_number(procrustes.residual)}};
  return json;
}

ordered_json pair_changes_json(const PairChanges& changes) {
  return {{"made", ids_json(changes.made)},
          {"broken", ids_json(changes.broken)},
          {"shift_mm", json_matrix(changes.shift_mm)},
          {"turn_deg", json_number(changes.turn_rad * kDegrees)}};
}

}  // namespace tetragauge
