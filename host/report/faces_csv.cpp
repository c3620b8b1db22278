// SPDX-License-Identifier: GPL-3.0-or-later
// The table of faces for a spreadsheet. Cells of what was not measured, or does not exist, are empty.
#include <algorithm>

#include "host/report/json_values.hpp"
#include "host/report/report.hpp"

namespace tetragauge {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

class Row {
 public:
  void text(const std::string& value) {
    cells_ += (is_first_ ? "" : ",") + value;
    is_first_ = false;
  }
  // Full digits and no locale, as in report.json.
  void number(double value) { text(json_number(value).dump()); }
  void count(size_t value) { text(std::to_string(value)); }
  void numbers_if(bool known, std::initializer_list<double> values) {
    for (const double value : values) known ? number(value) : text("");
  }
  const std::string& cells() const { return cells_; }

 private:
  std::string cells_;
  bool is_first_ = true;
};

constexpr const char* kHead =
    "face,surface,type,verdict,judged_by,datum,unit,deviation,U,limit,offset_mm,U_offset_mm,tilt_mrad,"
    "U_tilt_mrad,form_mm,U_form_mm,profile_mm,U_profile_mm,radius_mm,U_radius_mm,position_mm,U_position_mm,"
    "rms_mm,peak_to_valley_mm,machine_sigma_mm,points_mean_mm,points_rms_mm,points_p95_mm,points_max_mm,"
    "coverage,points_used,points_rejected,area_mm2,measured_area_mm2,reason";

std::string line(const FaceInspection& in, const Face& face) {
  Row row;
  row.count(static_cast<size_t>(face.id));
  row.count(static_cast<size_t>(face.surface));
  row.text(std::string(surface_type_name(face.type)));
  row.text(std::string(verdict_name(in.verdict)));
  if (in.decided_by) {
    row.text(in.decided_by->name);
    row.text(in.decided_by->datum);
    row.text(in.decided_by->is_angle() ? "mrad" : "mm");
    row.numbers_if(true, {in.decided_by->deviation, in.decided_by->U, in.decided_by->limit});
  } else {
    for (int k = 0; k < 6; ++k) row.text("");
  }
  const bool any = in.measured || in.coverage > 0;
  row.numbers_if(any, {in.offset_mm, in.U_offset_mm});
  row.numbers_if(any && face.type == SurfaceType::plane, {1e3 * in.tilt_rad, 1e3 * in.U_tilt_rad});
  row.numbers_if(any, {in.form_mm, in.U_form_mm, in.profile_mm, in.U_profile_mm});
  row.numbers_if(any && in.radius_mm.has_value(), {in.radius_mm.value_or(0), in.U_radius_mm});
  row.numbers_if(any && in.position_mm.has_value(), {in.position_mm.value_or(0), in.U_position_mm});
  row.numbers_if(any, {in.rms_mm, in.peak_to_valley_mm, in.machine_sigma_mm, in.point_mean_mm,
                       in.point_rms_mm, in.point_p95_mm, in.point_max_mm});
  row.number(in.coverage);
  row.count(in.points_used);
  row.count(in.points_rejected);
  row.number(face.area_mm2);
  row.number(in.measured_area_mm2);
  row.text(quoted(in.reason));
  return row.cells();
}

}  // namespace

std::string faces_csv(const Report& report) {
  std::string out = std::string(kHead) + "\r\n";
  for (size_t k = 0; k < report.run.inspection.faces.size(); ++k)
    out += line(report.run.inspection.faces[k], report.model.faces()[k]) + "\r\n";
  return out;
}

}  // namespace tetragauge
