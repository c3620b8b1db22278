// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/read_world.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>
#include <vector>

#include "host/base/nearest_name.hpp"
#include "host/base/whole_file.hpp"

namespace tetragauge::sim {
namespace {

using nlohmann::json;

constexpr double kDegree = std::numbers::pi / 180;

// A key's value, one number or three, goes into the setup.
struct Number {
  double lowest, highest;
  std::function<void(WorldSetup&, double)> set;
};
struct Triple {
  std::function<void(WorldSetup&, const Vec3&)> set;
};
using Key = std::variant<Number, Triple>;
using Section = std::map<std::string, Key, std::less<>>;

constexpr double kAny = 1e9;

Vec3 shifted_point(const Vec3& point, const RigidTransform& motion, const Vec3& centre) {
  return centre + motion.R * (point - centre) + motion.t;
}

// Laser and mirrors are one block.
void move_head(TrueGeometry& g, const RigidTransform& motion) {
  const Vec3 centre = g.mirror_b.pivot_mm;
  g.laser = {shifted_point(g.laser.point, motion, centre), motion.R * g.laser.direction};
  for (TrueMirror* mirror : {&g.mirror_a, &g.mirror_b}) {
    mirror->pivot_mm = shifted_point(mirror->pivot_mm, motion, centre);
    mirror->axis = motion.R * mirror->axis;
    mirror->normal_at_zero = motion.R * mirror->normal_at_zero;
  }
}

Section camera_keys(size_t c) {
  const auto camera = [c](WorldSetup& s) -> TrueCamera& { return s.geometry.cameras[c]; };
  return {
      {"shift_mm", Triple{[=](WorldSetup& s, const Vec3& v) {
         TrueCamera& k = camera(s);
         k.T_camera_machine.t -= k.T_camera_machine.R * v;
       }}},
      {"turn_deg", Triple{[=](WorldSetup& s, const Vec3& v) {
         TrueCamera& k = camera(s);
         k.T_camera_machine =
             RigidTransform{rotation_from_degrees(v.x(), v.y(), v.z()).transpose(), Vec3::Zero()} *
             k.T_camera_machine;
       }}},
      {"focal_mm", Number{5, 200, [=](WorldSetup& s, double v) { camera(s).focal_mm = v; }}},
      {"distortion", Number{-0.2, 0.2, [=](WorldSetup& s, double v) { camera(s).distortion = v; }}},
  };
}

Section mirror_keys(TrueMirror TrueGeometry::*mirror) {
  return {
      {"zero_deg",
       Number{-10, 10, [=](WorldSetup& s, double v) { (s.geometry.*mirror).zero_rad = v * kDegree; }}},
      {"scale", Number{0.5, 2, [=](WorldSetup& s, double v) { (s.geometry.*mirror).scale = v; }}},
  };
}

const std::map<std::string, Section, std::less<>>& sections() {
  static const std::map<std::string, Section, std::less<>> kSections{
      {"camera_1", camera_keys(0)},
      {"camera_2", camera_keys(1)},
      {"head",
       {{"shift_mm", Triple{[](WorldSetup& s, const Vec3& v) {
           move_head(s.geometry, {Mat3::Identity(), v});
         }}},
        {"turn_deg", Triple{[](WorldSetup& s, const Vec3& v) {
           move_head(s.geometry, {rotation_from_degrees(v.x(), v.y(), v.z()), Vec3::Zero()});
         }}}}},
      {"mirror_a", mirror_keys(&TrueGeometry::mirror_a)},
      {"mirror_b", mirror_keys(&TrueGeometry::mirror_b)},
      {"table",
       {{"axis_shift_mm", Triple{[](WorldSetup& s, const Vec3& v) { s.geometry.rotary_axis.point += v; }}},
        {"axis_turn_deg", Triple{[](WorldSetup& s, const Vec3& v) {
           Vec3& axis = s.geometry.rotary_axis.direction;
           axis = rotation_from_degrees(v.x(), v.y(), v.z()) * axis;
         }}}}},
      {"slide", {{"turn_deg", Triple{[](WorldSetup& s, const Vec3& v) {
                    s.geometry.slide_direction =
                        rotation_from_degrees(v.x(), v.y(), v.z()) * s.geometry.slide_direction;
                  }}}}},
      {"light",
       {{"laser_mW", Number{0, 100, [](WorldSetup& s, double v) { s.numbers.laser_W = v * 1e-3; }}},
        {"part_albedo", Number{0, 1, [](WorldSetup& s, double v) { s.numbers.part_albedo = v; }}},
        {"table_albedo", Number{0, 1, [](WorldSetup& s, double v) { s.numbers.table_albedo = v; }}},
        {"ambient_uA", Number{0, 100, [](WorldSetup& s, double v) { s.numbers.ambient_A = v * 1e-6; }}},
        {"speckle_contrast", Number{0, 1, [](WorldSetup& s, double v) { s.numbers.speckle_contrast = v; }}}}},
      {"electronics",
       {{"noise_bandwidth_Hz",
         Number{0, 1e7, [](WorldSetup& s, double v) { s.numbers.noise_bandwidth_Hz = v; }}},
        {"converter_bits",
         Number{8, 16, [](WorldSetup& s, double v) { s.numbers.converter_bits = static_cast<int>(v); }}},
        {"mirror_repeatability_urad",
         Number{0, 1000, [](WorldSetup& s, double v) { s.numbers.mirror_repeatability_rad = v * 1e-6; }}}}},
  };
  return kSections;
}

template <class Value>
Error unknown_key(const std::string& place, const std::string& key,
                  const std::map<std::string, Value, std::less<>>& known) {
  std::vector<std::string_view> names;
  for (const auto& entry : known) names.push_back(entry.first);
  return bad_input(place + ": unknown key \"" + key + "\"; did you mean \"" + nearest_name(key, names) +
                   "\"?");
}

Status apply(const std::string& place, const Key& key, const json& value, WorldSetup& setup) {
  if (const auto* number = std::get_if<Number>(&key)) {
    if (!value.is_number() || value.get<double>() < number->lowest || value.get<double>() > number->highest) {
      char text[96];
      std::snprintf(text, sizeof text, " must be a number from %g to %g", number->lowest, number->highest);
      return bad_input(place + text);
    }
    number->set(setup, value.get<double>());
    return Done{};
  }
  const auto is_finite_number = [](const json& v) {
    return v.is_number() && std::abs(v.get<double>()) < kAny;
  };
  if (!value.is_array() || value.size() != 3 || !std::all_of(value.begin(), value.end(), is_finite_number)) {
    return bad_input(place + " must be three numbers, e.g. [0.05, 0, 0]");
  }
  std::get<Triple>(key).set(setup,
                            Vec3(value[0].get<double>(), value[1].get<double>(), value[2].get<double>()));
  return Done{};
}

}  // namespace

Result<WorldSetup> read_world(const std::filesystem::path& path, WorldSetup setup) {
  const auto text = read_whole_file(path);
  if (!text) return text.error();
  const json root = json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (root.is_discarded() || !root.is_object()) {
    return bad_input(
        path.string() +
        ": not a JSON object; a world file looks like {\"camera_1\": {\"shift_mm\": [0.05, 0, 0]}}");
  }
  for (const auto& [section_name, section] : root.items()) {
    const auto known = sections().find(section_name);
    if (known == sections().end()) return unknown_key(path.string(), section_name, sections());
    const std::string place = path.string() + ": " + section_name;
    if (!section.is_object()) return bad_input(place + " must be an object");
    for (const auto& [name, value] : section.items()) {
      const auto key = known->second.find(name);
      if (key == known->second.end()) return unknown_key(place, name, known->second);
      if (const Status done = apply(place + "." + name, key->second, value, setup); !done)
        return done.error();
    }
  }
  return setup;
}

}  // namespace tetragauge::sim
