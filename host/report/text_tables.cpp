// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/text_tables.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

constexpr size_t kRelations = 12;  // lines of each kind; report.json has them all

bool has_deviations(const FaceInspection& in) {
  return in.measured || in.coverage > 0;
}

// In a column of `width`, with as many of the decimals as have room.
std::string fitted(double value, size_t width, int decimals, bool with_sign = false) {
  std::string text;
  for (int kept = decimals; kept >= 0; --kept) {
    text = print(with_sign ? "%+.*f" : "%.*f", kept, value + 0.0);
    if (text.size() <= width) break;
  }
  return text.size() > width ? print("%.0e", value) : text;
}

// In a column of 11.
std::string short_name(const Criterion& criterion) {
  std::string name = criterion.name == "parallelism"        ? "parallel"
                     : criterion.name == "perpendicularity" ? "square"
                     : criterion.name == "angularity"       ? "ang. mrad"
                                                            : criterion.name;
  if (!criterion.datum.empty()) name += " " + criterion.datum;
  return name;
}

template <class Significance>
std::vector<const FaceRelation*> farthest_out(const Report& report, bool parallel,
                                              const Significance& significance) {
  std::vector<const FaceRelation*> found;
  for (const FaceRelation& relation : report.run.inspection.relations)
    if (relation.are_parallel == parallel) found.push_back(&relation);
  std::stable_sort(found.begin(), found.end(), [&](const FaceRelation* a, const FaceRelation* b) {
    return significance(*a) > significance(*b);
  });
  return found;
}

std::string how_many(size_t all) {
  return all > kRelations ? print("the %zu of %zu farthest out; all stand in report.json", kRelations, all)
                          : std::string("farthest out first");
}

}  // namespace

std::string faces_table(const Report& report) {
  std::string out =
      "face type     points cover  off. mm tilt mr form mm judged by    deviat.   +- U  limit verdict\n";
  for (size_t k = 0; k < report.run.inspection.faces.size(); ++k) {
    const FaceInspection& in = report.run.inspection.faces[k];
    const Face& face = report.model.faces()[k];
    out += print("%4d %-8.8s %6zu %4.0f%%", face.id, std::string(surface_type_name(face.type)).c_str(),
                 in.points_used, 100 * in.coverage);
    const auto column = [&](const std::string& text, int width) {
      out += print(" %*s", width, text.c_str());
    };
    const bool any = has_deviations(in);
    column(any ? fitted(in.offset_mm, 8, 4, true) : "-", 8);
    column(any && face.type == SurfaceType::plane ? fitted(1e3 * in.tilt_rad, 7, 3) : "-", 7);
    column(any ? fitted(in.form_mm, 7, 4) : "-", 7);
    out += print(" %-11s", in.decided_by ? short_name(*in.decided_by).c_str() : "-");
    column(in.decided_by ? fitted(in.decided_by->deviation, 8, 4, true) : "-", 8);
    column(in.decided_by ? fitted(in.decided_by->U, 6, 4) : "-", 6);
    column(in.decided_by ? fitted(in.decided_by->limit, 6, 3) : "-", 6);
    out += " " + std::string(verdict_name(in.verdict)) + "\n";
  }
  return out;
}

std::string surface_table(const Report& report) {
  const auto& faces = report.run.inspection.faces;
  if (std::none_of(faces.begin(), faces.end(), has_deviations)) return "";
  std::string out =
      "surface, mm: what the fit leaves, beside the machine's own noise | all points to the model\n"
      "face      rms  peak-valley  machine |     mean      rms     95 %      max |  radius position\n";
  for (const FaceInspection& in : faces) {
    if (!has_deviations(in)) continue;
    out += print("%4d %8.4f %12.4f %8.4f | %+8.4f %8.4f %8.4f %8.4f", in.model_id, in.rms_mm,
                 in.peak_to_valley_mm, in.machine_sigma_mm, in.point_mean_mm + 0.0, in.point_rms_mm,
                 in.point_p95_mm, in.point_max_mm);
    if (in.radius_mm) out += print(" | %+7.4f %8.4f", *in.radius_mm + 0.0, in.position_mm.value_or(0));
    out += "\n";
  }
  return out;
}

std::string relations_table(const Report& report) {
  std::string out;
  const auto distances = farthest_out(report, true, [](const FaceRelation& r) {
    return std::abs(r.distance_deviation_mm) / std::max(1e-9, r.U_distance_mm);
  });
  if (!distances.empty()) {
    out += "distances of parallel faces, mm (" + how_many(distances.size()) + ")\n" +
           "  faces        distance    nominal  deviation   +- U   out of parallel mrad   +- U\n";
    for (size_t k = 0; k < std::min(kRelations, distances.size()); ++k) {
      const FaceRelation& r = *distances[k];
      out += print("%4d %4d %14.4f %10.4f %+10.4f %6.4f %22.3f %6.3f\n", r.first, r.second,
                   r.nominal_distance_mm + r.distance_deviation_mm, r.nominal_distance_mm,
                   r.distance_deviation_mm + 0.0, r.U_distance_mm, 1e3 * r.angle_deviation_rad,
                   1e3 * r.U_angle_rad);
    }
  }
  const auto angles = farthest_out(report, false, [](const FaceRelation& r) {
    return std::abs(r.angle_deviation_rad) / std::max(1e-12, r.U_angle_rad);
  });
  if (!angles.empty()) {
    out += (out.empty() ? "" : "\n") +
           ("angles between the normals of neighbours (" + how_many(angles.size()) + ")\n") +
           "  faces     angle degrees    nominal  deviation mrad   +- U\n";
    for (size_t k = 0; k < std::min(kRelations, angles.size()); ++k) {
      const FaceRelation& r = *angles[k];
      const double degrees = 180 / std::numbers::pi;
      out += print("%4d %4d %16.4f %10.4f %+15.3f %6.3f\n", r.first, r.second,
                   degrees * (r.nominal_angle_rad + r.angle_deviation_rad), degrees * r.nominal_angle_rad,
                   1e3 * r.angle_deviation_rad + 0.0, 1e3 * r.U_angle_rad);
    }
  }
  return out;
}

}  // namespace tetragauge
