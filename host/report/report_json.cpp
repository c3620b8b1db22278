// SPDX-License-Identifier: GPL-3.0-or-later
// report.json, key by key as DESIGN section 4 has it; report.schema.json beside this file says the same.
#include "host/inspect/decide.hpp"
#include "host/report/json_values.hpp"
#include "host/report/report.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

ordered_json tolerance_json(const FaceTolerance& tolerance) {
  ordered_json json = ordered_json::object();
  if (tolerance.profile_mm) json["profile_mm"] = json_number(*tolerance.profile_mm);
  if (tolerance.offset_mm) json["offset_mm"] = json_number(*tolerance.offset_mm);
  if (tolerance.flatness_mm) json["flatness_mm"] = json_number(*tolerance.flatness_mm);
  return json;
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
  json["deviations"] = ordered_json::object();
  json["U_mm"] = ordered_json::object();
  // Deviations of a face seen in part only are told too; `measured` and the verdict say what they are worth.
  if (in.measured || in.coverage > 0) {
    const bool plane = face.type == SurfaceType::plane;
    json["deviations"]["offset_mm"] = json_number(in.offset_mm);
    if (plane) json["deviations"]["tilt_mrad"] = json_number(1e3 * in.tilt_rad);
    json["deviations"]["form_mm"] = json_number(in.form_mm);
    json["deviations"]["profile_mm"] = json_number(in.profile_mm);
    json["deviations"]["rms_mm"] = json_number(in.rms_mm);
    json["U_mm"]["offset"] = json_number(in.U_offset_mm);
    if (plane) json["U_mm"]["tilt_mrad"] = json_number(1e3 * in.U_tilt_rad);
    json["U_mm"]["form"] = json_number(in.U_form_mm);
    json["U_mm"]["profile"] = json_number(in.U_profile_mm);
  }
  json["tolerance"] = tolerance_json(tolerance);
  json["verdict"] = verdict_name(in.verdict);
  if (!in.criterion.empty()) {
    json["decided_by"] = {{"criterion", in.criterion},
                          {"deviation_mm", json_number(in.deviation_mm)},
                          {"U_mm", json_number(in.U_mm)},
                          {"limit_mm", json_number(in.limit_mm)}};
  }
  if (in.candidate_with > 0) json["candidate_with"] = in.candidate_with;
  json["reason"] = in.reason;
  return json;
}

ordered_json extra_face_json(const Face& face, const RigidTransform& T_model_part, bool is_material) {
  const Vec3 normal = T_model_part.R * face.normal;
  const Vec3 point = T_model_part * face.point_mm;
  return {{"type", surface_type_name(face.type)},
          {"equation", {{"normal", json_matrix(normal)}, {"d_mm", json_number(normal.dot(point))}}},
          {"area_mm2", json_number(face.area_mm2)},
          {"point_mm", json_matrix(point)},
          {"out_of_tolerance", is_material}};
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

ordered_json report_json(const InspectionRun& run, const Scan& scan, const Solid& model,
                         const Tolerances& tolerances, const ReportInput& input) {
  const Inspection& inspection = run.inspection;
  ordered_json json;
  json["schema"] = "tetragauge/report/1";
  json["verdict"] = verdict_name(inspection.verdict);
  json["rule"] = inspection.rule;
  json.update(match_json(inspection.match, "search"));
  json["faces"] = ordered_json::array();
  for (size_t k = 0; k < inspection.faces.size(); ++k) {
    const Face& face = model.faces()[k];
    json["faces"].push_back(face_json(inspection.faces[k], face, tolerances.of(face)));
  }
  json["missing_faces"] = inspection.missing_faces;
  json["extra_faces"] = ordered_json::array();
  for (const int id : inspection.extra_faces) {
    const bool is_material =
        std::find(inspection.faces_out_of_model.begin(), inspection.faces_out_of_model.end(), id) !=
        inspection.faces_out_of_model.end();
    json["extra_faces"].push_back(extra_face_json(run.measured.faces()[static_cast<size_t>(id) - 1],
                                                  inspection.match.T_model_part, is_material));
  }
  json["material_faults"] = ordered_json::array();
  for (const MaterialFault& fault : inspection.material_faults) {
    json["material_faults"].push_back({{"kind", fault.missing ? "missing" : "excess"},
                                       {"face", fault.face},
                                       {"point_mm", json_matrix(fault.point_mm)},
                                       {"rays", fault.rays},
                                       {"depth_mm", json_number(fault.depth_mm)}});
  }
  json["smallest_feature_mm"] = json_number(inspection.smallest_feature_mm);
  json["misplaced"] = ordered_json::array();
  json["reconstruction"] = reconstruction_json(scan, run.reconstruction);
  json["points_on_faces"] = {{"used", run.measured.points_used}, {"rejected", run.measured.points_rejected}};
  const auto file = [](const std::string& name, const std::string& sha256) -> ordered_json {
    if (name.empty()) return nullptr;
    return {{"name", name}, {"sha256", sha256}};
  };
  json["input"] = {{"scan", file(input.scan_name, input.scan_sha256)},
                   {"model", file(input.model_name, input.model_sha256)},
                   {"tolerances", file(input.tolerances_name, input.tolerances_sha256)},
                   {"points", scan.size()},
                   {"model_faces", model.faces().size()},
                   {"machine_id", scan.header.machine_id},
                   {"calibration_id", scan.header.calibration_id},
                   {"u_cal_mm", json_number(scan.header.u_cal_mm)},
                   {"part_serial", scan.header.part_serial},
                   {"software", std::string("tetragauge ") + TETRAGAUGE_VERSION}};
  json["timing_s"] = ordered_json::object();
  for (const auto& [stage, seconds] : inspection.timing.stages_s())
    json["timing_s"][stage] = json_number(seconds);
  return json;
}

}  // namespace tetragauge
