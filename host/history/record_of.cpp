// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "host/history/part_record.hpp"

namespace tetragauge {
namespace {

// What is asked for: a part whose datum was not measured still belongs to the others held by it.
std::string held_by(const Tolerances& tolerances) {
  if (tolerances.datums.empty()) return "best fit";
  std::string text;
  for (const Datum& datum : tolerances.datums)
    text += (text.empty() ? "" : ", ") + datum.name + " face " + std::to_string(datum.face);
  return text;
}

// `distance` is no property of the face alone, and is judged only where it fails. `offset` has its own line.
bool is_kept(const Criterion& criterion) {
  return criterion.name != "distance" && criterion.name != "offset";
}

// Sizes that are never negative; what else is judged may lie on either side of nominal.
bool is_two_sided(const Criterion& criterion) {
  return criterion.name == "radius" || criterion.is_angle();
}

Quantity quantity_of(const Criterion& criterion) {
  Quantity quantity;
  quantity.name = criterion.datum.empty() ? criterion.name : criterion.name + " " + criterion.datum;
  quantity.unit = criterion.is_angle() ? "mrad" : "mm";
  quantity.U = criterion.U;
  quantity.upper = criterion.limit;
  if (is_two_sided(criterion)) {
    quantity.value = criterion.deviation;
    quantity.lower = -criterion.limit;
  } else {
    // The sign of a profile or a position only says to which side; its size is what is limited.
    quantity.value = std::abs(criterion.deviation);
  }
  return quantity;
}

bool is_judged(const std::vector<Criterion>& criteria, std::string_view name) {
  for (const Criterion& criterion : criteria)
    if (criterion.name == name) return true;
  return false;
}

FaceRecord face_record(const FaceInspection& in, const Face& face, const FaceTolerance& tolerance,
                       bool pose_is_known) {
  FaceRecord record{.face = in.model_id,
                    .type = std::string(surface_type_name(face.type)),
                    .measured = in.measured,
                    .coverage = in.coverage,
                    .verdict = in.verdict,
                    .reason = in.reason,
                    .quantities = {}};
  if (!in.measured) return record;
  Quantity offset{.name = "offset", .unit = "mm", .value = in.offset_mm, .U = in.U_offset_mm};
  offset.is_known = pose_is_known;
  if (const double limit = offset_limit(tolerance); limit < 1e200) {
    offset.lower = -limit;
    offset.upper = limit;
  }
  record.quantities.push_back(offset);
  for (const Criterion& criterion : in.criteria) {
    if (!is_kept(criterion)) continue;
    record.quantities.push_back(quantity_of(criterion));
    const bool needs_pose = criterion.name == "profile" || criterion.name == "position";
    record.quantities.back().is_known = pose_is_known || !needs_pose;
  }
  if (!is_judged(in.criteria, "flatness"))
    record.quantities.push_back({.name = "form", .unit = "mm", .value = in.form_mm, .U = in.U_form_mm});
  if (in.radius_mm && !is_judged(in.criteria, "radius"))
    record.quantities.push_back(
        {.name = "radius", .unit = "mm", .value = *in.radius_mm, .U = in.U_radius_mm});
  return record;
}

}  // namespace

PartRecord record_of(const Report& report) {
  const Inspection& inspection = report.run.inspection;
  const ScanHeader& header = report.scans.front().header;
  PartRecord record;
  record.part = header.part_serial;
  record.model_sha256 = report.model_file.sha256;
  record.model_name = report.model_file.name;
  record.tolerances_sha256 = report.tolerances_file.sha256;
  record.held_by = held_by(report.tolerances);
  record.machine_id = header.machine_id;
  record.calibration_id = header.calibration_id;
  record.operator_name = header.operator_name;
  record.start_time = header.start_time;
  record.seed = header.seed;
  record.verdict = inspection.verdict;
  const bool pose_is_known = inspection.alignment.problem.empty();
  for (size_t k = 0; k < inspection.faces.size(); ++k) {
    const Face& face = report.model.faces()[k];
    record.faces.push_back(face_record(inspection.faces[k], face, report.tolerances.of(face), pose_is_known));
  }
  return record;
}

}  // namespace tetragauge
