// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "host/base/excerpt.hpp"
#include "host/base/nearest_name.hpp"
#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"
#include "host/inspect/applies_to.hpp"
#include "host/inspect/tolerances.hpp"

namespace tetragauge {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 7> kTopKeys{"default", "type", "surface",     "face",
                                                   "datums",  "skip", "min_coverage"};
constexpr std::array kTypes{SurfaceType::plane,  SurfaceType::cylinder, SurfaceType::cone,
                            SurfaceType::sphere, SurfaceType::torus,    SurfaceType::other};

std::vector<std::string_view> tolerance_keys() {
  std::vector<std::string_view> names;
  for (const LimitKey& key : kLimitKeys) names.push_back(key.name);
  for (const DatumLimitKey& key : kDatumLimitKeys) names.push_back(key.name);
  return names;
}

class Reader {
 public:
  Reader(std::string name, const FaceList& model) : name_(std::move(name)), model_(model) {}

  Result<Tolerances> read(const std::string& text) {
    const Result<json> parsed = parse_json(text, name_);
    if (!parsed) return parsed.error();
    const json& root = *parsed;
    if (!root.is_object()) return wrong("", "must be an object, e.g. {\"default\": {\"profile_mm\": 0.1}}");
    out_.given = true;
    // Datums first: tolerances name them.
    if (root.contains("datums")) {
      if (Status status = read_datums(root["datums"]); !status) return status.error();
    }
    for (const auto& [key, value] : root.items())
      if (Status status = read_top(key, value); !status) return status.error();
    const bool judges = std::any_of(model_.faces.begin(), model_.faces.end(), [&](const Face& face) {
      return has_tolerance(out_.of(face)) && !out_.skip.contains(face.id);
    });
    if (!judges)
      return wrong(
          "", "gives no face of the model a tolerance; say one, e.g. {\"default\": {\"profile_mm\": 0.1}}");
    return out_;
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

  Status read_top(const std::string& key, const json& value) {
    if (key == "datums") return Done{};
    if (key == "default") return read_tolerance(key, value, out_.by_default);
    if (key == "min_coverage") {
      if (!value.is_number() || value.get<double>() < 0 || value.get<double>() > 1)
        return wrong(key, "must be a share from 0 to 1");
      out_.min_coverage = value.get<double>();
      return Done{};
    }
    if (key == "skip") return read_skip(value);
    if (key == "type") return read_types(value);
    if (key == "surface") {
      return read_by_id(key, value, out_.by_surface, [](const Face& face) { return face.surface; });
    }
    if (key == "face") {
      return read_by_id(key, value, out_.by_face, [](const Face& face) { return face.id; });
    }
    return unknown("", key, kTopKeys);
  }

  Result<double> positive(const std::string& place, const json& number) const {
    if (!number.is_number() || !(number.get<double>() > 0) || !std::isfinite(number.get<double>()))
      return wrong(place, "= " + excerpt(number.dump()) + " must be a number above 0" +
                              (place.ends_with("_mrad") ? " (mrad)" : " (mm)"));
    return number.get<double>();
  }

  Status read_tolerance(const std::string& place, const json& value, FaceTolerance& out) {
    if (!value.is_object()) return wrong(place, "must be an object, e.g. {\"profile_mm\": 0.1}");
    for (const auto& [name, content] : value.items()) {
      const auto named = [&name = name](const auto& key) { return key.name == name; };
      const std::string at = place + "." + name;
      if (const auto key = std::find_if(kLimitKeys.begin(), kLimitKeys.end(), named);
          key != kLimitKeys.end()) {
        const Result<double> limit = positive(at, content);
        if (!limit) return limit.error();
        out.*key->member = *limit;
      } else if (const auto to_datum = std::find_if(kDatumLimitKeys.begin(), kDatumLimitKeys.end(), named);
                 to_datum != kDatumLimitKeys.end()) {
        const Result<DatumTolerance> limit = read_datum_tolerance(at, content);
        if (!limit) return limit.error();
        out.*to_datum->member = *limit;
      } else {
        return unknown(place, name, tolerance_keys());
      }
    }
    return Done{};
  }

  Result<DatumTolerance> read_datum_tolerance(const std::string& place, const json& value) const {
    constexpr std::array<std::string_view, 2> known{"value", "datum"};
    const std::string example = "must be an object, e.g. {\"value\": 0.05, \"datum\": \"A\"}";
    if (!value.is_object()) return wrong(place, example);
    for (const auto& [key, content] : value.items())
      if (std::find(known.begin(), known.end(), key) == known.end()) return unknown(place, key, known);
    if (!value.contains("value") || !value.contains("datum") || !value["datum"].is_string())
      return wrong(place, example);
    const Result<double> limit = positive(place, value["value"]);
    if (!limit) return limit.error();
    const std::string datum = value["datum"].get<std::string>();
    if (!out_.datum(datum)) {
      std::string names;
      for (const Datum& have : out_.datums) names += (names.empty() ? "" : ", ") + have.name;
      return wrong(place + ".datum", "= \"" + excerpt(datum) + "\" is no datum of this file; " +
                                         (names.empty() ? "say its face, e.g. \"datums\": {\"A\": 3}"
                                                        : "`datums` has " + names));
    }
    return DatumTolerance{*limit, datum};
  }

  Status read_types(const json& value) {
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
      if (Status status = read_tolerance("type." + key, tolerance, out_.by_type[*type]); !status)
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
      const std::string place = what + "." + key;
      const Result<const Face*> face = face_with(what, place, id, id_of);
      if (!face) return face.error();
      if (Status status = read_tolerance(place, tolerance, out[id]); !status) return status;
      if (Status status = check_meaning(place, **face, out[id]); !status) return status;
    }
    return Done{};
  }

  // A default may pass over faces on which it means nothing; said of a face by its id, it is a mistake.
  Status check_meaning(const std::string& place, const Face& face, const FaceTolerance& tolerance) const {
    std::string key = "radius_mm";
    std::string why = tolerance.radius_mm ? why_no_radius(face) : "";
    for (const DatumLimitKey& limit : kDatumLimitKeys) {
      if (!why.empty() || !(tolerance.*limit.member)) continue;
      key = limit.name;
      why = why_not_to_datum(limit.name, face, *out_.datum((tolerance.*limit.member)->datum));
    }
    return why.empty() ? Status(Done{}) : wrong(place + "." + key + ":", why);
  }

  Status read_datums(const json& value) {
    if (!value.is_object())
      return wrong("datums", "must be an object of face ids, e.g. {\"A\": 3, \"B\": 1, \"C\": 5}");
    for (const auto& [name, content] : value.items()) {  // by name
      const std::string place = "datums." + excerpt(name);
      if (name.size() != 1 || name[0] < 'A' || name[0] > 'Z')
        return wrong(place, "is no datum's name: one capital letter, e.g. {\"A\": 3, \"B\": 1, \"C\": 5}");
      const Result<int> id = read_face_id(place, content);
      if (!id) return id.error();
      const Face& face = *std::find_if(model_.faces.begin(), model_.faces.end(),
                                       [&](const Face& candidate) { return candidate.id == *id; });
      if (face.type != SurfaceType::plane)
        return wrong(place, "= " + std::to_string(*id) + " is a " +
                                std::string(surface_type_name(face.type)) +
                                "; a datum must be a plane face (`tetragauge model` lists them)");
      out_.datums.push_back({name, *id, face.normal});
    }
    if (out_.datums.empty()) return wrong("datums", "names no face, e.g. {\"A\": 3, \"B\": 1, \"C\": 5}");
    return check_holding();
  }

  // Primary, secondary, tertiary: each must hold what those before it leave free.
  Status check_holding() const {
    const std::vector<Datum>& d = out_.datums;
    const auto says = [](const Datum& datum) {
      return datum.name + " (face " + std::to_string(datum.face) + ")";
    };
    if (d.size() > 1 && is_parallel(d[0].normal, d[1].normal))
      return wrong("datums." + d[1].name,
                   "= " + std::to_string(d[1].face) + " is parallel to " + says(d[0]) +
                       " and holds nothing that it leaves free; name a face across it");
    if (d.size() > 2 && is_perpendicular(d[0].normal.cross(d[1].normal).normalized(), d[2].normal))
      return wrong("datums." + d[2].name, "= " + std::to_string(d[2].face) + " holds nothing that " +
                                              says(d[0]) + " and " + says(d[1]) +
                                              " leave free; name a face across both");
    return Done{};
  }

  Result<int> read_face_id(const std::string& place, const json& value) const {
    // One beyond int would come as another face.
    if (!value.is_number_integer() || value < 1 || value > std::numeric_limits<int>::max())
      return wrong(place, "= " + excerpt(value.dump()) + " must be a face id");
    const Result<const Face*> face =
        face_with("face", place, value.get<int>(), [](const Face& candidate) { return candidate.id; });
    if (!face) return face.error();
    return value.get<int>();
  }

  Status read_skip(const json& value) {
    if (!value.is_array()) return wrong("skip", "must be a list of face ids, e.g. [7]");
    for (size_t k = 0; k < value.size(); ++k) {
      const Result<int> id = read_face_id("skip[" + std::to_string(k) + "]", value[k]);
      if (!id) return id.error();
      out_.skip.insert(*id);
    }
    return Done{};
  }

  template <class IdOf>
  Result<const Face*> face_with(const std::string& what, const std::string& place, int id, IdOf id_of) const {
    int last = 0;
    for (const Face& face : model_.faces) {
      if (id_of(face) == id) return &face;
      last = std::max(last, id_of(face));
    }
    return wrong(place, "names " + what + " " + std::to_string(id) + ", but the model's " + what +
                            "s are 1 to " + std::to_string(last) + "; `tetragauge model` lists them");
  }

  std::string name_;
  const FaceList& model_;
  Tolerances out_;
};

}  // namespace

Result<Tolerances> read_tolerances(const std::filesystem::path& path, const FaceList& model) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return Reader(path.string(), model).read(*text);
}

}  // namespace tetragauge
