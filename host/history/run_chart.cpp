// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/run_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

constexpr std::array kBlocks{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr std::array kAscii{"_", ".", "-", "~", "\""};
constexpr int kPictureRows = 11;

struct Span {
  double low, high;
};

// A size that is never negative starts at 0.
Span scale_of(const QuantityHistory& quantity) {
  const ControlChart& chart = quantity.chart;
  if (quantity.upper) return {quantity.lower.value_or(0), *quantity.upper};
  return {chart.centre - 3 * chart.sigma, chart.centre + 3 * chart.sigma};
}

bool is_out_of_control(const QuantityHistory& quantity, size_t index) {
  const auto& signals = quantity.chart.signals;
  return std::any_of(signals.begin(), signals.end(),
                     [&](const OutOfControl& signal) { return signal.index == index; });
}

bool is_beyond_limits(const QuantityHistory& quantity, double value) {
  return (quantity.upper && value > *quantity.upper) || (quantity.lower && value < *quantity.lower);
}

std::string red(const std::string& text, bool wanted) {
  return wanted ? "\x1b[1;31m" + text + "\x1b[0m" : text;
}

std::string mark_of(const Span& scale, double value, bool unicode) {
  if (value > scale.high) return unicode ? "▲" : "A";
  if (value < scale.low) return unicode ? "▼" : "V";
  const size_t levels = unicode ? kBlocks.size() : kAscii.size();
  const double width = scale.high - scale.low;
  const double share = width > 0 ? (value - scale.low) / width : 0.5;
  const size_t level = std::min(levels - 1, static_cast<size_t>(share * static_cast<double>(levels)));
  return unicode ? kBlocks[level] : kAscii[level];
}

// Index into values of each part shown; -1: none.
std::vector<int> values_by_part(const QuantityHistory& quantity, size_t parts) {
  std::vector<int> index(parts, -1);
  for (size_t k = 0; k < quantity.values.size(); ++k) index[quantity.values[k].part] = static_cast<int>(k);
  const size_t shown = std::min(parts, kChartColumns);
  return {index.end() - static_cast<std::ptrdiff_t>(shown), index.end()};
}

}  // namespace

std::string run_chart_line(const QuantityHistory& quantity, size_t parts, const HistoryTextOptions& options) {
  const Span scale = scale_of(quantity);
  std::string text;
  for (const int at : values_by_part(quantity, parts)) {
    if (at < 0) {
      text += "?";
      continue;
    }
    const size_t index = static_cast<size_t>(at);
    const double value = quantity.values[index].value;
    const bool is_bad = is_beyond_limits(quantity, value) || is_out_of_control(quantity, index);
    text += red(mark_of(scale, value, options.unicode), options.colour && is_bad);
  }
  return text;
}

std::string run_chart_picture(const QuantityHistory& quantity, size_t parts,
                              const HistoryTextOptions& options) {
  // All values, and the limits unless they are so far away that the values would become one line.
  const Capability& c = quantity.capability;
  const ControlChart& chart = quantity.chart;
  Span scale{std::min(c.min, chart.centre - 3 * chart.sigma),
             std::max(c.max, chart.centre + 3 * chart.sigma)};
  const double near = 0.5 * std::max(scale.high - scale.low, 1e-6);
  const auto reach = [&](const std::optional<double>& limit) {
    if (!limit || *limit < scale.low - near || *limit > scale.high + near) return;
    scale = {std::min(scale.low, *limit), std::max(scale.high, *limit)};
  };
  reach(quantity.lower);
  reach(quantity.upper);
  const double step = std::max(scale.high - scale.low, 1e-6) / (kPictureRows - 1);
  const double bottom = 0.5 * (scale.low + scale.high) - step * (kPictureRows - 1) / 2;
  const auto row_of = [&](double value) { return static_cast<int>(std::lround((value - bottom) / step)); };

  const std::vector<int> shown = values_by_part(quantity, parts);
  std::string text;
  for (int row = kPictureRows - 1; row >= 0; --row) {
    // A line that means something shows its own number instead of the row's.
    std::string name;
    double number = bottom + row * step;
    const auto add_name = [&](double value, const char* what) {
      if (row_of(value) != row) return;
      if (name.empty()) number = value;
      name += (name.empty() ? "" : ", ") + std::string(what);
    };
    if (quantity.upper) add_name(*quantity.upper, "limit");
    if (quantity.lower) add_name(*quantity.lower, "limit");
    add_name(chart.centre, "mean");
    if (chart.sigma > 0) {
      add_name(chart.centre + 3 * chart.sigma, "+3 sigma");
      add_name(chart.centre - 3 * chart.sigma, "-3 sigma");
    }
    text += print("%16s %+9.4f ", name.c_str(), number + 0.0) + (options.unicode ? "┤" : "|");
    const std::string background = name.empty() ? " " : options.unicode ? "┄" : "-";
    for (const int at : shown) {
      if (at < 0 || row_of(quantity.values[static_cast<size_t>(at)].value) != row) {
        text += background;
        continue;
      }
      const size_t index = static_cast<size_t>(at);
      const bool is_bad = is_beyond_limits(quantity, quantity.values[index].value);
      const bool is_out = is_out_of_control(quantity, index);
      text += red(is_bad            ? "X"
                  : is_out          ? "O"
                  : options.unicode ? "●"
                                    : "o",
                  options.colour && (is_bad || is_out));
    }
    text += "\n";
  }
  return text;
}

std::string run_chart_legend(const HistoryTextOptions& options) {
  std::string levels;
  if (options.unicode) {
    for (const char* block : kBlocks) levels += block;
  } else {
    for (const char* level : kAscii) levels += level;
  }
  return "(" + levels + " from the lower limit, or 0, to the upper; " + (options.unicode ? "▼ ▲" : "V A") +
         " beyond; no limits: +-3 sigma; ? no value)\n";
}

}  // namespace tetragauge
