// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>

#include "host/session/plan.hpp"

namespace tetragauge {
namespace {

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value + 0.0);
  return text;
}

}  // namespace

std::string plan_json(const ScanPlan& plan) {
  std::string text = "{\n  \"views\": [";
  const char* between = "\n";
  for (const PlannedView& view : plan.views) {
    const RasterWindow& w = view.window;
    text += between;
    text += "    {\"table_deg\": " + text_of(view.table_deg) + ", \"slide_mm\": " + text_of(view.slide_mm) +
            ", \"window_mm\": {\"y\": [" + text_of(w.y_min_mm) + ", " + text_of(w.y_max_mm) + "], \"up\": [" +
            text_of(w.up_min_mm) + ", " + text_of(w.up_max_mm) +
            "]}, \"pitch_mm\": " + text_of(view.pitch_mm) + ", \"samples\": " + std::to_string(view.samples) +
            "}";
    between = ",\n";
  }
  return text + "\n  ]\n}\n";
}

}  // namespace tetragauge
