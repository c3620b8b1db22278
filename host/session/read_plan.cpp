// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/base/excerpt.hpp"
#include "host/base/nearest_name.hpp"
#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"
#include "host/session/plan.hpp"
#include "host/session/plan_limits.hpp"

namespace tetragauge {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 4> kPlanKeys{"views", "window_mm", "pitch_mm", "samples"};
constexpr std::array<std::string_view, 5> kViewKeys{"table_deg", "slide_mm", "window_mm", "pitch_mm",
                                                    "samples"};
constexpr std::array<std::string_view, 2> kWindowKeys{"y", "up"};

Status check_keys(const json& object, const std::string& place, std::span<const std::string_view> known) {
  if (!object.is_object()) return bad_input(place + " must be an object");
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      return bad_input(place + ": unknown key \"" + excerpt(key) + "\"; did you mean \"" +
                       nearest_name(key, known) + "\"?");
    }
  }
  return Done{};
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

struct Range {
  double lowest, highest;
  const char* beyond;  // why
};

constexpr Range kTable{kTableLowest_deg, kTableHighest_deg,
                       "the table's soft limits of -180 to 360 degrees; use the same angle within them"};
constexpr Range kSlide{kSlideLowest_mm, kSlideHighest_mm,
                       "the slide's 300 mm; lower it or re-home with a longer slide"};
constexpr Range kWindow{-kWindowReach_mm, kWindowReach_mm,
                        "what the mirrors reach and the cameras see, 110 mm either side; narrow the window"};
constexpr Range kPitch{kFinestPitch_mm, kCoarsestPitch_mm, "0.02 to 50 mm"};
constexpr Range kSamples{kFewestSamples, kMostSamples, "2 to 4096 samples"};

Status read_number(const json& value, const std::string& place, const Range& range, double& out) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    return bad_input(place + " must be a number");
  const double number = value.get<double>();
  if (number < range.lowest || number > range.highest) {
    return bad_input(place + " = " + number_text(number) + " is beyond " + range.beyond);
  }
  out = number;
  return Done{};
}

Status read_span(const json& value, const std::string& place, double& low, double& high) {
  if (!value.is_array() || value.size() != 2) return bad_input(place + " must be two numbers, [from, to]");
  for (size_t i = 0; i < 2; ++i) {
    if (const Status done =
            read_number(value[i], place + "[" + std::to_string(i) + "]", kWindow, i == 0 ? low : high);
        !done) {
      return done;
    }
  }
  if (low > high) return bad_input(place + ": from is above to; swap them");
  return Done{};
}

Status read_window(const json& value, const std::string& place, RasterWindow& window) {
  if (const Status done = check_keys(value, place, kWindowKeys); !done) return done;
  if (value.contains("y")) {
    if (const Status done = read_span(value["y"], place + ".y", window.y_min_mm, window.y_max_mm); !done)
      return done;
  }
  if (value.contains("up")) return read_span(value["up"], place + ".up", window.up_min_mm, window.up_max_mm);
  return Done{};
}

// Keys that a view may set itself or take from the plan.
Status read_raster(const json& object, const std::string& place, PlannedView& view) {
  if (object.contains("window_mm")) {
    if (const Status done = read_window(object["window_mm"], place + "window_mm", view.window); !done)
      return done;
  }
  if (object.contains("pitch_mm")) {
    if (const Status done = read_number(object["pitch_mm"], place + "pitch_mm", kPitch, view.pitch_mm); !done)
      return done;
  }
  if (object.contains("samples")) {
    double samples = 0;
    if (const Status done = read_number(object["samples"], place + "samples", kSamples, samples); !done)
      return done;
    if (std::fmod(samples, 2) != 0) {
      return bad_input(place + "samples = " + number_text(samples) +
                       " must be even: half as many are taken before and after");
    }
    view.samples = static_cast<uint32_t>(samples);
  }
  return Done{};
}

}  // namespace

Result<ScanPlan> read_plan(const std::filesystem::path& path) {
  const auto text = read_whole_file(path);
  if (!text) return text.error();
  const std::string name = path.string();
  const Result<json> parsed = parse_json(*text, name);
  if (!parsed) return parsed.error();
  const json& root = *parsed;
  if (const Status done = check_keys(root, name, kPlanKeys); !done) return done.error();
  PlannedView common;
  if (const Status done = read_raster(root, name + ": ", common); !done) return done.error();
  if (!root.contains("views") || !root["views"].is_array() || root["views"].empty()) {
    return bad_input(name +
                     ": \"views\" must list at least one view, e.g. [{\"table_deg\": 0, \"slide_mm\": 150}]");
  }
  ScanPlan plan;
  for (size_t i = 0; i < root["views"].size(); ++i) {
    const json& entry = root["views"][i];
    const std::string at = name + ": views[" + std::to_string(i) + "]";
    if (const Status done = check_keys(entry, at, kViewKeys); !done) return done.error();
    if (!entry.contains("table_deg") || !entry.contains("slide_mm")) {
      return bad_input(at + " needs table_deg and slide_mm");
    }
    PlannedView view = common;
    if (const Status done = read_number(entry["table_deg"], at + ".table_deg", kTable, view.table_deg);
        !done) {
      return done.error();
    }
    if (const Status done = read_number(entry["slide_mm"], at + ".slide_mm", kSlide, view.slide_mm); !done) {
      return done.error();
    }
    if (const Status done = read_raster(entry, at + ".", view); !done) return done.error();
    plan.views.push_back(view);
  }
  return plan;
}

}  // namespace tetragauge
