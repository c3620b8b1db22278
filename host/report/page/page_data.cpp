// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/page_data.hpp"

#include <algorithm>
#include <cmath>

#include "host/report/json_values.hpp"
#include "host/report/page/deviation_field.hpp"
#include "host/report/page/display_mesh.hpp"
#include "host/report/page/histogram.hpp"
#include "host/report/page/packed.hpp"
#include "host/report/page/points_in_model.hpp"
#include "host/report/page/range_images.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

constexpr size_t kMostPoints = 30000;  // shown; a base64 of 13 bytes each
constexpr double kStepsToLimit = 500;  // int16 then reaches to 65 limits
constexpr size_t kMostPatchTriangles = 4000;

// +- limit of a face's deviation from its surface; 0: none.
double limit_of(const Report& report, const Face& face) {
  const double limit = offset_limit(report.tolerances.of(face));
  return limit < 1e300 && !report.tolerances.skip.contains(face.id) ? limit : 0;
}

double middle_of(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// What the colours are about: the limit that most faces have; without any the deviation that 19 of 20 points
// keep to.
double typical_limit(const Report& report, bool& has_limits) {
  std::vector<double> values;
  for (const Face& face : report.model.faces())
    if (const double limit = limit_of(report, face); limit > 0) values.push_back(limit);
  has_limits = !values.empty();
  if (has_limits) return middle_of(values, 0.5);
  const Inspection& inspection = report.run.inspection;
  for (size_t i = 0; i < inspection.point_face.size(); ++i)
    if (inspection.point_face[i] > 0)
      values.push_back(std::abs(static_cast<double>(inspection.point_deviation_mm[i])));
  return values.empty() ? 1 : std::max(1e-6, middle_of(values, 0.95));
}

// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): a choice of points without the stripes that every n-th would
// show.
uint64_t scrambled(uint64_t index) {
  uint64_t z = (index + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

ordered_json points_json(const Report& report, std::span<const Vec3> points, const Box& box, double unit_mm) {
  const Inspection& inspection = report.run.inspection;
  const size_t n = points.size();
  std::vector<Vec3> places;
  std::vector<float> deviations;
  std::vector<uint32_t> faces;
  size_t outside = 0;
  for (size_t i = 0; i < n; ++i) {
    if (n > kMostPoints && scrambled(i) % n >= kMostPoints) continue;
    if (!box.holds(points[i])) {
      ++outside;
      continue;
    }
    places.push_back(points[i]);
    deviations.push_back(inspection.point_deviation_mm[i]);
    faces.push_back(std::min(65535u, static_cast<uint32_t>(inspection.point_face[i])));
  }
  return {{"all", n},
          {"shown", places.size()},
          {"outside", outside},
          {"places", packed_places(places, box)},
          {"deviations", packed_lengths(deviations, unit_mm)},
          {"faces", packed<uint16_t>(faces)}};
}

ordered_json mesh_json(const Report& report, std::span<const Vec3> points, const Box& box, double unit_mm) {
  const DisplayMesh mesh = display_mesh(report.model);
  std::vector<uint16_t> corners;
  for (const auto& triangle : mesh.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  std::vector<uint32_t> ids;
  for (const uint32_t face : mesh.vertex_face) ids.push_back(std::min(65535u, face + 1));
  return {{"places", packed_places(mesh.vertices, box)},
          {"faces", packed<uint16_t>(ids)},
          {"deviations", packed_lengths(deviation_field(mesh, report, points), unit_mm)},
          {"triangles", packed<uint16_t>(corners)},
          {"coarser", mesh.is_coarser}};
}

// The reconstructed surface of each face that the model does not have.
ordered_json extra_json(const Report& report, const Box& box) {
  ordered_json list = ordered_json::array();
  for (const ExtraFace& extra : report.run.inspection.extra_faces) {
    const SetUp& set_up = report.run.set_ups[extra.set_up];
    std::vector<Vec3> corners;
    const auto& faces = set_up.measured.face_triangles;
    const size_t k = static_cast<size_t>(extra.measured_id) - 1;
    if (k < faces.size()) {
      for (const uint32_t t : faces[k]) {
        if (corners.size() >= 3 * kMostPatchTriangles) break;
        for (const uint32_t vertex : set_up.reconstruction.surface[t].vertex)
          corners.push_back(set_up.match.T_model_part * set_up.reconstruction.vertices[vertex]);
      }
    }
    list.push_back(packed_places(corners, box));
  }
  return list;
}

ordered_json histograms_json(const Report& report) {
  const Inspection& inspection = report.run.inspection;
  std::vector<std::vector<float>> of_face(report.model.faces().size());
  for (size_t i = 0; i < inspection.point_face.size(); ++i)
    if (inspection.point_face[i] > 0)
      of_face[static_cast<size_t>(inspection.point_face[i]) - 1].push_back(inspection.point_deviation_mm[i]);
  ordered_json list = ordered_json::array();
  for (size_t k = 0; k < of_face.size(); ++k) {
    const Histogram bins = histogram(of_face[k], limit_of(report, report.model.faces()[k]));
    list.push_back({{"half_width_mm", json_number(bins.half_width_mm)}, {"counts", bins.counts}});
  }
  return list;
}

ordered_json normals_json(const Report& report) {
  ordered_json model = ordered_json::array(), measured = ordered_json::array();
  for (const Face& face : report.model.faces()) {
    model.push_back({{"id", face.id},
                     {"type", surface_type_name(face.type)},
                     {"normal", json_matrix(face.normal)},
                     {"axis", json_matrix(face.axis)},
                     {"half_angle_rad", json_number(face.half_angle_rad)},
                     {"point_mm", json_matrix(face.point_mm)},
                     {"area_mm2", json_number(face.area_mm2)},
                     {"limit_mm", json_number(limit_of(report, face))}});
  }
  for (size_t s = 0; s < report.run.set_ups.size(); ++s) {
    const SetUp& set_up = report.run.set_ups[s];
    for (const Face& face : set_up.measured.faces()) {
      int model_id = 0;
      for (const FacePair& pair : set_up.match.pairs)
        if (pair.measured == face.id) model_id = pair.model;
      measured.push_back({{"id", face.id},
                          {"scan", s + 1},
                          {"model", model_id},
                          {"normal", json_matrix(set_up.match.T_model_part.R * face.normal)},
                          {"area_mm2", json_number(face.area_mm2)}});
    }
  }
  return {{"model", model}, {"measured", measured}};
}

ordered_json images_json(const Report& report, double unit_mm) {
  ordered_json list = ordered_json::array();
  for (const RangeImage& image : range_images(report)) {
    list.push_back({{"scan", image.set_up + 1},
                    {"views", image.views},
                    {"perspective", image.is_perspective},
                    {"pixel", json_number(image.pixel)},
                    {"width", image.width},
                    {"height", image.height},
                    {"rays", image.rays},
                    {"on_model", image.on_model},
                    {"mean_mm", json_number(image.mean_mm)},
                    {"rms_mm", json_number(image.rms_mm)},
                    {"beyond", packed_lengths(image.beyond_mm, unit_mm)},
                    {"faces", packed<uint16_t>(image.face)}});
  }
  return list;
}

}  // namespace

ordered_json page_data(const Report& report, ordered_json json) {
  // Points within half the part's size of it are drawn; the box of the numbers is that of the picture.
  const Vec3 margin =
      Vec3::Constant(0.5 * (report.model.box_max_mm - report.model.box_min_mm).maxCoeff() + 1e-6);
  const Box box{report.model.box_min_mm - margin, report.model.box_max_mm + margin};
  bool has_limits = false;
  const double limit_mm = typical_limit(report, has_limits);
  const double unit_mm = limit_mm / kStepsToLimit;
  const std::vector<Vec3> points = points_in_model(report);
  return {{"report", std::move(json)},
          {"box_mm", {json_matrix(box.low_mm), json_matrix(box.high_mm)}},
          {"part_mm", {json_matrix(report.model.box_min_mm), json_matrix(report.model.box_max_mm)}},
          {"unit_mm", json_number(unit_mm)},
          {"limit_mm", json_number(limit_mm)},
          {"has_limits", has_limits},
          {"mesh", mesh_json(report, points, box, unit_mm)},
          {"points", points_json(report, points, box, unit_mm)},
          {"extra_patches", extra_json(report, box)},
          {"histograms", histograms_json(report)},
          {"normals", normals_json(report)},
          {"images", images_json(report, unit_mm)}};
}

}  // namespace tetragauge
