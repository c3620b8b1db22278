// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/geometry/face_list_file.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "host/base/excerpt.hpp"
#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"
#include "host/geometry/parse_number.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

constexpr const char* kNoLength = "is zero or beyond all numbers; give its direction with a length of 1";
constexpr const char* kTooLarge = "the plane or the area is beyond 1e15 mm; check the numbers and the unit";

bool is_length(double norm) {
  return norm >= 1e-9 && norm <= 1e15;
}
bool is_size(double value) {
  return std::abs(value) <= 1e15;
}

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
      return bad_input(place + "'" + excerpt(word) +
                       "' is not a face id (an integer from 1); expected: id a b c d area");
    if (!ids.insert(*id).second)
      return bad_input(place + "face " + std::to_string(*id) +
                       " stands here for the second time; number each face once");
    std::array<double, 5> v{};  // a b c d area
    for (double& value : v) {
      word = next_word(line);
      const auto number_read = parse_number<double>(word);
      if (!number_read) {
        return bad_input(place +
                         (word.empty() ? "the line ends early" : "'" + excerpt(word) + "' is not a number") +
                         "; expected: id a b c d area");
      }
      value = *number_read;
    }
    if (!next_word(line).empty()) return bad_input(place + "more than six values; expected: id a b c d area");
    const Vec3 abc(v[0], v[1], v[2]);
    if (!is_length(abc.norm())) return bad_input(place + "the normal (a b c) " + kNoLength);
    if (v[4] < 0) return bad_input(place + "the area is negative; expected: id a b c d area");
    Face face;
    face.id = face.surface = *id;
    face.normal = abc.normalized();
    face.d_mm = -v[3] / abc.norm() * unit_scale_mm;  // a x + b y + c z + d = 0
    face.area_mm2 = v[4] * unit_scale_mm * unit_scale_mm;
    face.point_mm = face.normal * face.d_mm;  // a list tells no centroid: the foot of the origin
    if (!is_size(face.d_mm) || !is_size(face.area_mm2)) return bad_input(place + kTooLarge);
    list.faces.push_back(face);
  }
  if (list.faces.empty()) return bad_input(name + ": no face in it; expected lines: id a b c d area");
  return list;
}

Vec3 vec_from_json(const nlohmann::json& value) {
  if (!value.is_array() || value.size() != 3) throw std::runtime_error("expected three numbers");
  for (const nlohmann::json& number : value) {
    if (!number.is_number()) throw std::runtime_error("expected three numbers");
  }
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

// A library's conversion would make another number of one beyond int, or of a fraction.
int whole_number(const nlohmann::json& value, const std::string& key, int lowest) {
  if (!value.is_number_integer() || value < lowest || value > std::numeric_limits<int>::max())
    throw std::runtime_error(key + " is not a whole number from " + std::to_string(lowest));
  return value.get<int>();
}

double size_of(const nlohmann::json& value, const std::string& key) {
  if (!value.is_number() || !is_size(value.get<double>()))
    throw std::runtime_error(key + " is not a number below 1e15");
  return value.get<double>();
}

double size_or_zero(const nlohmann::json& face, const std::string& key) {
  return face.contains(key) ? size_of(face[key], key) : 0.0;
}

Vec3 unit_vec_from_json(const nlohmann::json& value, const std::string& key) {
  const Vec3 v = vec_from_json(value);
  if (!is_length(v.norm())) throw std::runtime_error("the " + key + " " + kNoLength);
  return v.normalized();
}

Face face_from_json(const nlohmann::json& value) {
  Face face;
  face.id = whole_number(value.at("id"), "id", 1);
  face.surface = value.contains("surface") ? whole_number(value["surface"], "surface", 0) : face.id;
  const std::string type_name = value.at("type").get<std::string>();
  const auto type = surface_type_from_name(type_name);
  if (!type) throw std::runtime_error("unknown surface type '" + excerpt(type_name) + "'");
  face.type = *type;
  if (face.type == SurfaceType::plane) {
    face.normal = unit_vec_from_json(value.at("normal"), "normal");
    face.d_mm = size_of(value.at("d_mm"), "d_mm") / vec_from_json(value["normal"]).norm();
    if (!is_size(face.d_mm)) throw std::runtime_error(kTooLarge);
  }
  if (value.contains("axis")) face.axis = unit_vec_from_json(value["axis"], "axis");
  if (value.contains("point_on_axis_mm")) face.point_on_axis_mm = vec_from_json(value["point_on_axis_mm"]);
  face.radius_mm = size_or_zero(value, "radius_mm");
  face.minor_radius_mm = size_or_zero(value, "minor_radius_mm");
  face.half_angle_rad = size_or_zero(value, "half_angle_rad");
  face.concave = value.value("concave", false);
  face.point_mm =
      value.contains("point_mm") ? vec_from_json(value["point_mm"]) : Vec3(face.normal * face.d_mm);
  face.area_mm2 = size_or_zero(value, "area_mm2");
  if (face.area_mm2 < 0) throw std::runtime_error("area_mm2 is negative");
  if (value.contains("neighbours")) {
    if (!value["neighbours"].is_array()) throw std::runtime_error("neighbours: expected a list of ids");
    for (const nlohmann::json& id : value["neighbours"])
      face.neighbours.push_back(whole_number(id, "neighbours", 1));
  }
  if (value.contains("points")) face.points = static_cast<size_t>(whole_number(value["points"], "points", 0));
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

Result<FaceList> parse_faces_json(const std::string& text, const std::string& name) {
  const Result<nlohmann::json> parsed = parse_json(text, name);
  if (!parsed) return parsed.error();
  const nlohmann::json& root = *parsed;
  if (!root.is_object()) {
    return bad_input(name +
                     ": not a JSON object; expected what `tetragauge faces --json` writes, or a .hsp list");
  }
  FaceList list;
  size_t index = 0;
  bool in_faces = false;
  try {
    const std::string unit = root.value("unit", std::string("mm"));
    if (unit != "mm") return bad_input(name + ": unit '" + excerpt(unit) + "': face lists in JSON are in mm");
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
  return usage_error("unit '" + excerpt(unit) + "' is not one of mm, cm, m, um, inch");
}

Result<FaceList> read_face_list(const std::filesystem::path& path, double unit_scale_mm) {
  Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  if (path.extension() == ".hsp") return parse_hsp(*text, path.string(), unit_scale_mm);
  return parse_faces_json(*text, path.string());
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
