// SPDX-License-Identifier: GPL-3.0-or-later
// report.json, key by key as DESIGN section 4 has it; report.schema.json beside this file says the same.
#include <numbers>

#include "host/report/json_values.hpp"
#include "host/report/report.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

constexpr double kDegrees = 180 / std::numbers::pi;

ordered_json tolerance_json(const FaceTolerance& tolerance) {
  ordered_json json = ordered_json::object();
  for (const LimitKey& key : kLimitKeys)
    if (const auto& limit = tolerance.*key.member) json[key.name] = json_number(*limit);
  for (const DatumLimitKey& key : kDatumLimitKeys)
    if (const auto& limit = tolerance.*key.member)
      json[key.name] = {{"value", json_number(limit->value)}, {"datum", limit->datum}};
  return json;
}

ordered_json criterion_json(const Criterion& criterion) {
  const std::string unit = criterion.is_angle() ? "_mrad" : "_mm";
  ordered_json json{{"criterion", criterion.name},
                    {"deviation" + unit, json_number(criterion.deviation)},
                    {"U" + unit, json_number(criterion.U)},
                    {"limit" + unit, json_number(criterion.limit)},
                    {"verdict", verdict_name(criterion.verdict)}};
  if (!criterion.datum.empty()) json["datum"] = criterion.datum;
  return json;
}

void add_deviations(const FaceInspection& in, const Face& face, ordered_json& json) {
  ordered_json deviations = ordered_json::object(), U = ordered_json::object();
  const auto add = [&](const char* key, const char* U_key, double deviation, double uncertainty) {
    deviations[key] = json_number(deviation);
    U[U_key] = json_number(uncertainty);
  };
  // Deviations of a face seen in part only are told too; `measured` and the verdict say what they are worth.
  const bool any = in.measured || in.coverage > 0;
  if (any) {
    add("offset_mm", "offset", in.offset_mm, in.U_offset_mm);
    if (face.type == SurfaceType::plane)
      add("tilt_mrad", "tilt_mrad", 1e3 * in.tilt_rad, 1e3 * in.U_tilt_rad);
    if (in.radius_mm) add("radius_mm", "radius", *in.radius_mm, in.U_radius_mm);
    if (in.position_mm) add("position_mm", "position", *in.position_mm, in.U_position_mm);
    add("form_mm", "form", in.form_mm, in.U_form_mm);
    add("profile_mm", "profile", in.profile_mm, in.U_profile_mm);
  }
  json["deviations"] = deviations;
  json["U_mm"] = U;
  if (!any) return;
  json["roughness"] = {{"rms_mm", json_number(in.rms_mm)},
                       {"peak_to_valley_mm", json_number(in.peak_to_valley_mm)},
                       {"machine_sigma_mm", json_number(in.machine_sigma_mm)}};
  json["points_to_model"] = {{"mean_mm", json_number(in.point_mean_mm)},
                             {"rms_mm", json_number(in.point_rms_mm)},
                             {"p95_mm", json_number(in.point_p95_mm)},
                             {"max_mm", json_number(in.point_max_mm)}};
}

ordered_json face_json(const FaceInspection& in, const Face& face, const FaceTolerance& tolerance) {
  ordered_json json;
  json["id"] = face.id;
  json["surface"] = face.surface;
  json["type"] = surface_type_name(face.type);
  json["measured"] = in.measured;
  json["points_used"] = in.points_used;
  json["points_rejected"] = in.points_rejected;
  json["area_mm2"] = json_number(face.area_mm2);
  json["measured_area_mm2"] = json_number(in.measured_area_mm2);
  json["coverage"] = json_number(in.coverage);
  add_deviations(in, face, json);
  json["tolerance"] = tolerance_json(tolerance);
  json["verdict"] = verdict_name(in.verdict);
  json["criteria"] = ordered_json::array();
  for (const Criterion& criterion : in.criteria) json["criteria"].push_back(criterion_json(criterion));
  if (in.decided_by) json["decided_by"] = criterion_json(*in.decided_by);
  if (in.candidate_with > 0) json["candidate_with"] = in.candidate_with;
  json["reason"] = in.reason;
  return json;
}

ordered_json relation_json(const FaceRelation& in) {
  const double sign = in.nominal_angle_rad > 1 && in.are_parallel ? -1 : 1;  // opposed: less than 180 degrees
  ordered_json json{
      {"faces", {in.first, in.second}},
      {"neighbours", in.are_neighbours},
      {"parallel", in.are_parallel},
      {"angle_deg", json_number(kDegrees * (in.nominal_angle_rad + sign * in.angle_deviation_rad))},
      {"nominal_angle_deg", json_number(kDegrees * in.nominal_angle_rad)},
      {"angle_deviation_mrad", json_number(1e3 * in.angle_deviation_rad)},
      {"U_angle_mrad", json_number(1e3 * in.U_angle_rad)}};
  if (in.are_parallel) {
    json["distance_mm"] = json_number(in.nominal_distance_mm + in.distance_deviation_mm);
    json["nominal_distance_mm"] = json_number(in.nominal_distance_mm);
    json["distance_deviation_mm"] = json_number(in.distance_deviation_mm);
    json["U_distance_mm"] = json_number(in.U_distance_mm);
  }
  return json;
}

ordered_json alignment_json(const Alignment& alignment) {
  ordered_json datums = ordered_json::array();
  for (const Alignment::Held& held : alignment.datums) {
    datums.push_back({{"datum", held.datum},
                      {"face", held.face},
                      {"rotations", held.rotations},
                      {"translations", held.translations}});
  }
  return {{"kind", alignment.datums.empty() ? "best_fit" : "datums"},
          {"datums", datums},
          {"problem", alignment.problem}};
}

ordered_json extra_face_json(const ExtraFace& extra) {
  return {{"type", surface_type_name(extra.face.type)},
          {"equation", {{"normal", json_matrix(extra.face.normal)}, {"d_mm", json_number(extra.face.d_mm)}}},
          {"area_mm2", json_number(extra.face.area_mm2)},
          {"point_mm", json_matrix(extra.face.point_mm)},
          {"out_of_tolerance", extra.out_of_tolerance},
          {"scan", extra.set_up + 1}};
}

ordered_json doubts_json(const Doubts& in) {
  return {{"doubtful", in.doubtful},     {"doubtful_mm3", json_number(in.doubtful_mm3)},
          {"resolvable", in.resolvable}, {"resolvable_mm3", json_number(in.resolvable_mm3)},
          {"undecided", in.undecided},   {"not_measured", in.not_measured}};
}

ordered_json story_json(const MeasuringStory& story) {
  ordered_json rounds = ordered_json::array();
  for (const MeasuringRound& round : story.rounds) {
    rounds.push_back({{"rays", round.rays},
                      {"views", round.views},
                      {"points", round.points},
                      {"before", doubts_json(round.before)},
                      {"after", doubts_json(round.after)},
                      {"machine_s", json_number(round.machine_s)}});
  }
  return {{"plan", json_text(story.plan)},
          {"rounds", rounds},
          {"rounds_end", story.end},
          {"interruption", json_text(story.interruption)}};
}

ordered_json file_json(const ReportFile& file) {
  if (file.name.empty()) return nullptr;
  return {{"name", json_text(file.name)}, {"sha256", file.sha256}};
}

ordered_json points_json(const MeasuredFaces& measured) {
  return {{"used", measured.points_used}, {"rejected", measured.points_rejected}};
}

ordered_json further_set_up_json(const Report& report, size_t index) {
  const SetUp& set_up = report.run.set_ups[index];
  ordered_json json{{"scan", file_json(report.scan_files[index])}};
  json.update(match_json(set_up.match, "search"));
  json["reconstruction"] = reconstruction_json(report.scans[index], set_up.reconstruction);
  json["points_on_faces"] = points_json(set_up.measured);
  return json;
}

}  // namespace

ordered_json reconstruction_json(const Scan& scan, const Reconstruction& reconstruction) {
  return {{"points", scan.size()},
          {"vertices", reconstruction.vertices.size()},
          {"tetrahedra", reconstruction.tetrahedra},
          {"air", reconstruction.air},
          {"solid", reconstruction.solid},
          {"doubtful", reconstruction.doubtful},
          {"volume_mm3", json_number(reconstruction.volume_mm3)},
          {"area_mm2", json_number(reconstruction.area_mm2)},
          {"centroid_mm", json_matrix(reconstruction.centroid_mm)},
          {"inertia_mm5", json_matrix(reconstruction.inertia_mm5)},
          {"rays_walked", reconstruction.rays_walked},
          {"rays_lost", reconstruction.rays_lost},
          {"closed", reconstruction.closed}};
}

ordered_json report_json(const Report& report) {
  const Inspection& inspection = report.run.inspection;
  const SetUp& first = report.run.set_ups.front();
  const ScanHeader& header = report.scans.front().header;
  ordered_json json;
  json["schema"] = "tetragauge/report/1";
  json["verdict"] = verdict_name(inspection.verdict);
  json["rule"] = rule_name(inspection.rule);
  json["alignment"] = alignment_json(inspection.alignment);
  json.update(match_json(first.match, "search"));
  json["faces"] = ordered_json::array();
  for (size_t k = 0; k < inspection.faces.size(); ++k) {
    const Face& face = report.model.faces()[k];
    json["faces"].push_back(face_json(inspection.faces[k], face, report.tolerances.of(face)));
  }
  json["relations"] = ordered_json::array();
  for (const FaceRelation& relation : inspection.relations)
    json["relations"].push_back(relation_json(relation));
  json["missing_faces"] = inspection.missing_faces;
  json["extra_faces"] = ordered_json::array();
  for (const ExtraFace& extra : inspection.extra_faces) json["extra_faces"].push_back(extra_face_json(extra));
  json["material_faults"] = ordered_json::array();
  for (const MaterialFault& fault : inspection.material_faults) {
    json["material_faults"].push_back({{"kind", fault.missing ? "missing" : "excess"},
                                       {"face", fault.face},
                                       {"point_mm", json_matrix(fault.point_mm)},
                                       {"rays", fault.rays},
                                       {"depth_mm", json_number(fault.depth_mm)}});
  }
  json["smallest_feature_mm"] = json_number(inspection.smallest_feature_mm);
  json["reconstruction"] = reconstruction_json(report.scans.front(), first.reconstruction);
  json["points_on_faces"] = points_json(first.measured);
  json["further_set_ups"] = ordered_json::array();
  for (size_t k = 1; k < report.run.set_ups.size(); ++k)
    json["further_set_ups"].push_back(further_set_up_json(report, k));
  if (report.story) json.update(story_json(*report.story));
  json["input"] = {{"scan", file_json(report.scan_files.front())},
                   {"model", file_json(report.model_file)},
                   {"tolerances", file_json(report.tolerances_file)},
                   {"points", inspection.point_face.size()},
                   {"model_faces", report.model.faces().size()},
                   {"machine_id", json_text(header.machine_id)},
                   {"calibration_id", json_text(header.calibration_id)},
                   {"u_cal_mm", json_number(header.u_cal_mm)},
                   {"part_serial", json_text(header.part_serial)},
                   {"software", std::string("tetragauge ") + TETRAGAUGE_VERSION}};
  // The stages of several scans follow one another; one entry a stage.
  json["timing_s"] = ordered_json::object();
  for (const auto& [stage, seconds] : inspection.timing.stages_s())
    json["timing_s"][stage] = json_number(seconds + json["timing_s"].value(stage, 0.0));
  return json;
}

}  // namespace tetragauge
