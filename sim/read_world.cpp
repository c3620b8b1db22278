// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/read_world.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>
#include <vector>

#include "host/base/excerpt.hpp"
#include "host/base/nearest_name.hpp"
#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"

namespace tetragauge::sim {
namespace {

using nlohmann::json;

constexpr double kDegree = std::numbers::pi / 180;

// A key's value, one number or three, goes into the setup.
struct Number {
  double lowest, highest;
  std::function<void(WorldSetup&, double)> set;
  bool whole = false;
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

Number number(double lowest, double highest, double Numbers::*field, double unit = 1) {
  return {lowest, highest, [=](WorldSetup& s, double v) { s.numbers.*field = v * unit; }, false};
}
Number number(double lowest, double highest, double MirrorDynamics::*field) {
  return {lowest, highest, [=](WorldSetup& s, double v) { s.numbers.mirror.*field = v; }, false};
}
Number whole_number(double lowest, double highest, int Numbers::*field) {
  return {lowest, highest, [=](WorldSetup& s, double v) { s.numbers.*field = static_cast<int32_t>(v); },
          true};
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
         }}},
        {"top_turn_deg", Triple{[](WorldSetup& s, const Vec3& v) {
           s.geometry.table_top_normal = rotation_from_degrees(v.x(), v.y(), v.z()) * Vec3::UnitZ();
         }}}}},
      {"slide", {{"turn_deg", Triple{[](WorldSetup& s, const Vec3& v) {
                    s.geometry.slide_direction =
                        rotation_from_degrees(v.x(), v.y(), v.z()) * s.geometry.slide_direction;
                  }}}}},
      {"light",
       {{"laser_mW", number(0, 100, &Numbers::laser_W, 1e-3)},
        {"wavelength_nm", number(200, 1200, &Numbers::wavelength_mm, 1e-6)},
        {"waist_mm", number(0.005, 5, &Numbers::waist_mm)},
        {"focus_mm", number(50, 5000, &Numbers::focus_distance_mm)},
        {"laser_rise_us", number(0.01, 1e5, &Numbers::laser_rise_s, 1e-6)},
        {"part_albedo", number(0, 1, &Numbers::part_albedo)},
        {"table_albedo", number(0, 1, &Numbers::table_albedo)},
        {"ambient_uA", number(0, 100, &Numbers::ambient_A, 1e-6)},
        {"ambient_flicker", number(0, 1, &Numbers::ambient_flicker)},
        {"ambient_drift_uA_s", number(0, 10, &Numbers::ambient_drift_A_s, 1e-6)},
        {"speckle_contrast", number(0, 1, &Numbers::speckle_contrast)}}},
      {"detector",
       {{"aperture_radius_mm", number(0.1, 50, &Numbers::aperture_radius_mm)},
        {"lens_transmission", number(0, 1, &Numbers::lens_transmission)},
        {"responsivity_A_W", number(0, 1, &Numbers::responsivity_A_W)},
        {"electrode_resistance_ohm", number(1, 1e9, &Numbers::electrode_resistance_ohm)},
        {"temperature_K", number(0, 400, &Numbers::temperature_K)}}},
      {"electronics",
       {{"amplifier_noise_nV", number(0, 1000, &Numbers::amplifier_voltage_noise_V, 1e-9)},
        {"gain_V_A", number(1, 1e9, &Numbers::gain_V_A)},
        {"full_scale_V", number(0.1, 20, &Numbers::full_scale_V)},
        {"noise_bandwidth_Hz", number(0, 1e7, &Numbers::noise_bandwidth_Hz)},
        {"converter_bits", whole_number(8, 16, &Numbers::converter_bits)},
        {"converter_noise_lsb", number(0, 1000, &Numbers::converter_noise_lsb)},
        {"converter_inl_lsb", number(0, 1000, &Numbers::converter_inl_lsb)}}},
      {"mirrors",
       {{"natural_rad_s", number(100, 1e6, &MirrorDynamics::natural_rad_s)},
        {"damping", number(0.05, 0.99, &MirrorDynamics::damping)},
        {"slew_rad_s", number(0.1, 1e5, &MirrorDynamics::slew_rad_s)},
        {"repeatability_urad", number(0, 1000, &Numbers::mirror_repeatability_rad, 1e-6)},
        {"urad_per_code", number(0.1, 100, &Numbers::rad_per_mirror_code, 1e-6)}}},
      {"stage",
       {{"table_steps_per_turn", whole_number(100, 10e6, &Numbers::table_steps_per_turn)},
        {"slide_um_per_step", number(0.01, 1000, &Numbers::slide_mm_per_step, 1e-3)},
        {"table_backlash_steps", whole_number(0, 10e3, &Numbers::table_backlash_steps)},
        {"slide_backlash_steps", whole_number(0, 10e3, &Numbers::slide_backlash_steps)},
        {"table_home_steps", whole_number(-10e6, 10e6, &Numbers::table_home_steps)},
        {"slide_home_steps", whole_number(-10e6, 10e6, &Numbers::slide_home_steps)},
        {"slide_limit_low_steps", whole_number(-10e6, 10e6, &Numbers::slide_limit_low_steps)},
        {"slide_limit_high_steps", whole_number(-10e6, 10e6, &Numbers::slide_limit_high_steps)},
        {"table_start_steps", whole_number(-10e6, 10e6, &Numbers::table_start_steps)},
        {"slide_start_steps", whole_number(-10e6, 10e6, &Numbers::slide_start_steps)}}},
  };
  return kSections;
}

template <class Value>
Error unknown_key(const std::string& place, const std::string& key,
                  const std::map<std::string, Value, std::less<>>& known) {
  std::vector<std::string_view> names;
  for (const auto& entry : known) names.push_back(entry.first);
  return bad_input(place + ": unknown key \"" + excerpt(key) + "\"; did you mean \"" +
                   nearest_name(key, names) + "\"?");
}

Status apply(const std::string& place, const Key& key, const json& value, WorldSetup& setup) {
  if (const auto* number = std::get_if<Number>(&key)) {
    if (!value.is_number() || value.get<double>() < number->lowest || value.get<double>() > number->highest) {
      char text[96];
      std::snprintf(text, sizeof text, " must be a number from %g to %g", number->lowest, number->highest);
      return bad_input(place + text);
    }
    if (number->whole && value.get<double>() != std::floor(value.get<double>()))
      return bad_input(place + " must be a whole number");
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
  const Result<json> parsed = parse_json(*text, path.string());
  if (!parsed) return parsed.error();
  const json& root = *parsed;
  if (!root.is_object()) {
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
