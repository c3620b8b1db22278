// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/tolerances.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>

#include "host/base/excerpt.hpp"
#include "host/base/nearest_name.hpp"
#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"
#include "host/inspect/decide.hpp"

namespace tetragauge {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 6> kTopKeys{"default", "type", "surface",
                                                   "face",    "skip", "min_coverage"};
constexpr std::array<std::string_view, 3> kToleranceKeys{"profile_mm", "offset_mm", "flatness_mm"};
constexpr std::array kTypes{SurfaceType::plane,  SurfaceType::cylinder, SurfaceType::cone,
                            SurfaceType::sphere, SurfaceType::torus,    SurfaceType::other};

class Reader {
 public:
  Reader(std::string name, const FaceList& model) : name_(std::move(name)), model_(model) {}

  Result<Tolerances> read(const std::string& text) {
    const Result<json> parsed = parse_json(text, name_);
    if (!parsed) return parsed.error();
    const json& root = *parsed;
    Tolerances out;
    out.given = true;
    if (!root.is_object()) return wrong("", "must be an object, e.g. {\"default\": {\"profile_mm\": 0.1}}");
    for (const auto& [key, value] : root.items()) {
      if (Status status = read_top(key, value, out); !status) return status.error();
    }
    const bool judges = std::any_of(model_.faces.begin(), model_.faces.end(), [&](const Face& face) {
      return has_tolerance(out.of(face)) && !out.skip.contains(face.id);
    });
    if (!judges)
      return wrong(
          "", "gives no face of the model a tolerance; say one, e.g. {\"default\": {\"profile_mm\": 0.1}}");
    return out;
  }

 private:
  Error wrong(const std::string& place, const std::string& what) const {
    return bad_input(name_ + ": " + (place.empty() ? "" : place + " ") + what);
  }

  Error unknown(const std::string& place, std::string_view key,
                std::span<const std::string_view> known) const {
    return bad_input(name_ + ": " + (place.empty() ? "" : place + ".") + excerpt(key) +
                     " is no known key; did you mean " + nearest_name(key, known) + "?");
  }

  Status read_top(const std::string& key, const json& value, Tolerances& out) {
    if (key == "default") return read_tolerance(key, value, out.by_default);
    if (key == "min_coverage") {
      if (!value.is_number() || value.get<double>() < 0 || value.get<double>() > 1)
        return wrong(key, "must be a share from 0 to 1");
      out.min_coverage = value.get<double>();
      return Done{};
    }
    if (key == "skip") return read_skip(value, out);
    if (key == "type") return read_types(value, out);
    if (key == "surface") {
      return read_by_id(key, value, out.by_surface, [](const Face& face) { return face.surface; });
    }
    if (key == "face") {
      return read_by_id(key, value, out.by_face, [](const Face& face) { return face.id; });
    }
    return unknown("", key, kTopKeys);
  }

  Status read_tolerance(const std::string& place, const json& value, FaceTolerance& out) {
    if (!value.is_object()) return wrong(place, "must be an object, e.g. {\"profile_mm\": 0.1}");
    for (const auto& [key, number] : value.items()) {
      if (std::find(kToleranceKeys.begin(), kToleranceKeys.end(), key) == kToleranceKeys.end())
        return unknown(place, key, kToleranceKeys);
      if (!number.is_number() || !(number.get<double>() > 0) || !std::isfinite(number.get<double>()))
        return wrong(place + "." + key, "= " + excerpt(number.dump()) + " must be a number above 0 (mm)");
      const double mm = number.get<double>();
      (key == "profile_mm" ? out.profile_mm : key == "offset_mm" ? out.offset_mm : out.flatness_mm) = mm;
    }
    return Done{};
  }

  Status read_types(const json& value, Tolerances& out) {
    if (!value.is_object())
      return wrong("type", "must be an object, e.g. {\"plane\": {\"profile_mm\": 0.1}}");
    for (const auto& [key, tolerance] : value.items()) {
      std::vector<std::string_view> names;
      const SurfaceType* type = nullptr;
      for (const SurfaceType& known : kTypes) {
        names.push_back(surface_type_name(known));
        if (names.back() == key) type = &known;
      }
      if (!type) return unknown("type", key, names);
      if (Status status = read_tolerance("type." + key, tolerance, out.by_type[*type]); !status)
        return status;
    }
    return Done{};
  }

  template <class IdOf>
  Status read_by_id(const std::string& what, const json& value, std::map<int, FaceTolerance>& out,
                    IdOf id_of) {
    if (!value.is_object()) return wrong(what, "must be an object, e.g. {\"12\": {\"flatness_mm\": 0.02}}");
    for (const auto& [key, tolerance] : value.items()) {
      int id = 0;
      const auto [end, code] = std::from_chars(key.data(), key.data() + key.size(), id);
      if (code != std::errc{} || end != key.data() + key.size())
        return wrong(what + "." + excerpt(key), "is no " + what + " id; ids are whole numbers from 1");
      if (Status status = check_id(what, what + "." + key, id, id_of); !status) return status;
      if (Status status = read_tolerance(what + "." + key, tolerance, out[id]); !status) return status;
    }
    return Done{};
  }

  Status read_skip(const json& value, Tolerances& out) {
    if (!value.is_array()) return wrong("skip", "must be a list of face ids, e.g. [7]");
    for (size_t k = 0; k < value.size(); ++k) {
      const std::string place = "skip[" + std::to_string(k) + "]";
      // One beyond int would come as another face.
      if (!value[k].is_number_integer() || value[k] < 1 || value[k] > std::numeric_limits<int>::max())
        return wrong(place, "= " + excerpt(value[k].dump()) + " must be a face id");
      const int id = value[k].get<int>();
      if (Status status = check_id("face", place, id, [](const Face& face) { return face.id; }); !status)
        return status;
      out.skip.insert(id);
    }
    return Done{};
  }

  template <class IdOf>
  Status check_id(const std::string& what, const std::string& place, int id, IdOf id_of) const {
    int last = 0;
    for (const Face& face : model_.faces) {
      if (id_of(face) == id) return Done{};
      last = std::max(last, id_of(face));
    }
    return wrong(place, "names " + what + " " + std::to_string(id) + ", but the model's " + what +
                            "s are 1 to " + std::to_string(last) + "; `tetragauge model` lists them");
  }

  std::string name_;
  const FaceList& model_;
};

}  // namespace

FaceTolerance Tolerances::of(const Face& face) const {
  FaceTolerance out = by_default;
  const auto overlay = [&](const auto& map, const auto& key) {
    const auto at = map.find(key);
    if (at == map.end()) return;
    if (at->second.profile_mm) out.profile_mm = at->second.profile_mm;
    if (at->second.offset_mm) out.offset_mm = at->second.offset_mm;
    if (at->second.flatness_mm) out.flatness_mm = at->second.flatness_mm;
  };
  overlay(by_type, face.type);
  overlay(by_surface, face.surface);
  overlay(by_face, face.id);
  return out;
}

Result<Tolerances> read_tolerances(const std::filesystem::path& path, const FaceList& model) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return Reader(path.string(), model).read(*text);
}

}  // namespace tetragauge
