// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/geometry/face_list_file.hpp"

#include <array>
#include <cmath>
#include <set>
#include <string>

#include "host/base/whole_file.hpp"
#include "host/geometry/parse_number.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

Result<FaceList> parse_hsp(std::string_view text, const std::string& name, double unit_scale_mm) {
  FaceList list;
  std::set<int> ids;
  for (int number = 1; !text.empty(); ++number) {
    std::string_view line = next_line(text);
    line = line.substr(0, line.find('#'));
    const std::string place = name + ":" + std::to_string(number) + ": ";
    std::string_view word = next_word(line);
    if (word.empty()) continue;
    const auto id = parse_number<int>(word);
    if (!id || *id < 1)
      return bad_input(place + "'" + std::string(word) + "' is not a face id (an integer from 1)");
    if (!ids.insert(*id).second)
      return bad_input(place + "face " + std::to_string(*id) + " stands here twice");
    std::array<double, 5> v{};  // a b c d area
    for (double& value : v) {
      word = next_word(line);
      const auto number_read = parse_number<double>(word);
      if (!number_read) {
        return bad_input(
            place + (word.empty() ? "the line ends early" : "'" + std::string(word) + "' is not a number") +
            "; expected: id a b c d area");
      }
      value = *number_read;
    }
    if (!next_word(line).empty()) return bad_input(place + "more than six values; expected: id a b c d area");
    const Vec3 abc(v[0], v[1], v[2]);
    if (abc.norm() < 1e-9) return bad_input(place + "the normal (a b c) is zero");
    if (v[4] < 0) return bad_input(place + "the area is negative");
    Face face;
    face.id = face.surface = *id;
    face.normal = abc.normalized();
    face.d_mm = -v[3] / abc.norm() * unit_scale_mm;  // a x + b y + c z + d = 0
    face.area_mm2 = v[4] * unit_scale_mm * unit_scale_mm;
    face.point_mm = face.normal * face.d_mm;  // a list tells no centroid: the foot of the origin
    list.faces.push_back(face);
  }
  if (list.faces.empty()) return bad_input(name + ": no face in it; expected lines: id a b c d area");
  return list;
}

Vec3 vec_from_json(const nlohmann::json& value) {
  if (!value.is_array() || value.size() != 3) throw std::runtime_error("expected three numbers");
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

Face face_from_json(const nlohmann::json& value) {
  Face face;
  face.id = value.at("id").get<int>();
  face.surface = value.value("surface", face.id);
  const std::string type_name = value.at("type").get<std::string>();
  const auto type = surface_type_from_name(type_name);
  if (!type) throw std::runtime_error("unknown surface type '" + type_name + "'");
  face.type = *type;
  if (face.type == SurfaceType::plane) {
    const Vec3 normal = vec_from_json(value.at("normal"));
    if (normal.norm() < 1e-9) throw std::runtime_error("the normal is zero");
    face.normal = normal.normalized();
    face.d_mm = value.at("d_mm").get<double>() / normal.norm();
  }
  if (value.contains("axis")) face.axis = vec_from_json(value["axis"]);
  if (value.contains("point_on_axis_mm")) face.point_on_axis_mm = vec_from_json(value["point_on_axis_mm"]);
  face.radius_mm = value.value("radius_mm", 0.0);
  face.minor_radius_mm = value.value("minor_radius_mm", 0.0);
  face.half_angle_rad = value.value("half_angle_rad", 0.0);
  face.concave = value.value("concave", false);
  face.point_mm =
      value.contains("point_mm") ? vec_from_json(value["point_mm"]) : Vec3(face.normal * face.d_mm);
  face.area_mm2 = value.value("area_mm2", 0.0);
  face.neighbours = value.value("neighbours", std::vector<int>{});
  face.points = value.value("points", size_t{0});
  if (value.contains("covariance")) {
    PlaneCovariance covariance;
    const nlohmann::json& rows = value["covariance"];
    if (!rows.is_array() || rows.size() != 3) throw std::runtime_error("covariance: expected 3 x 3 numbers");
    for (int row = 0; row < 3; ++row)
      covariance.matrix.row(row) = vec_from_json(rows[static_cast<size_t>(row)]);
    covariance.u = vec_from_json(value.at("u"));
    covariance.v = vec_from_json(value.at("v"));
    face.covariance = covariance;
  }
  return face;
}

Result<FaceList> parse_json(const std::string& text, const std::string& name) {
  FaceList list;
  size_t index = 0;
  bool in_faces = false;
  try {
    const nlohmann::json root = nlohmann::json::parse(text);
    const std::string unit = root.value("unit", std::string("mm"));
    if (unit != "mm") return bad_input(name + ": unit '" + unit + "': face lists in JSON are in mm");
    std::set<int> ids;
    in_faces = true;
    for (const nlohmann::json& value : root.at("faces")) {
      list.faces.push_back(face_from_json(value));
      if (!ids.insert(list.faces.back().id).second)
        throw std::runtime_error("its id stands in the list twice");
      ++index;
    }
  } catch (const std::exception& error) {
    return bad_input(name + (in_faces ? ": faces[" + std::to_string(index) + "]" : "") + ": " + error.what() +
                     "; expected what `tetragauge faces --json` writes");
  }
  if (list.faces.empty()) return bad_input(name + ": no face in it");
  return list;
}

// Minus zero reads like a fault; no result needs it.
double plain(double value) {
  return value == 0 ? 0.0 : value;
}
ordered_json vec_json(const Vec3& v) {
  return {plain(v.x()), plain(v.y()), plain(v.z())};
}

}  // namespace

Result<double> unit_mm(std::string_view unit) {
  if (unit == "mm") return 1.0;
  if (unit == "cm") return 10.0;
  if (unit == "m") return 1000.0;
  if (unit == "um") return 1e-3;
  if (unit == "inch" || unit == "in") return 25.4;
  return usage_error("unit '" + std::string(unit) + "' is not one of mm, cm, m, um, inch");
}

Result<FaceList> read_face_list(const std::filesystem::path& path, double unit_scale_mm) {
  Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  if (path.extension() == ".hsp") return parse_hsp(*text, path.string(), unit_scale_mm);
  return parse_json(*text, path.string());
}

ordered_json face_to_json(const Face& face) {
  ordered_json json;
  json["id"] = face.id;
  json["surface"] = face.surface;
  json["type"] = surface_type_name(face.type);
  if (face.type == SurfaceType::plane) {
    json["normal"] = vec_json(face.normal);
    json["d_mm"] = plain(face.d_mm);
  }
  if (face.type == SurfaceType::cylinder || face.type == SurfaceType::cone ||
      face.type == SurfaceType::torus) {
    json["axis"] = vec_json(face.axis);
  }
  if (face.type != SurfaceType::plane && face.type != SurfaceType::other) {
    json["point_on_axis_mm"] = vec_json(face.point_on_axis_mm);
    json["radius_mm"] = face.radius_mm;
    json["concave"] = face.concave;
  }
  if (face.type == SurfaceType::torus) json["minor_radius_mm"] = face.minor_radius_mm;
  if (face.type == SurfaceType::cone) json["half_angle_rad"] = face.half_angle_rad;
  json["point_mm"] = vec_json(face.point_mm);
  json["area_mm2"] = face.area_mm2;
  if (face.covariance) {
    json["covariance"] = ordered_json::array();
    for (int row = 0; row < 3; ++row)
      json["covariance"].push_back(vec_json(face.covariance->matrix.row(row)));
    json["u"] = vec_json(face.covariance->u);
    json["v"] = vec_json(face.covariance->v);
  }
  json["neighbours"] = face.neighbours;
  json["points"] = face.points;
  return json;
}

ordered_json face_list_to_json(const FaceList& list, std::string_view schema) {
  ordered_json json;
  json["schema"] = schema;
  json["unit"] = "mm";
  json["faces"] = ordered_json::array();
  for (const Face& face : list.faces) json["faces"].push_back(face_to_json(face));
  return json;
}

}  // namespace tetragauge
