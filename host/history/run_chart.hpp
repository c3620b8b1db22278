// SPDX-License-Identifier: GPL-3.0-or-later
// A quantity over the parts, drawn with characters.
#pragma once

#include <string>

#include "host/history/summary.hpp"

namespace tetragauge {

inline constexpr size_t kChartColumns = 60;

// One character a part, the last kChartColumns of `parts`: its height between the limits (without limits
// within 3 sigma of the centre), a mark above or below when it is beyond them, '?' where there is no value.
std::string run_chart_line(const QuantityHistory& quantity, size_t parts, const HistoryTextOptions& options);

// Several lines high, with limits, centre and control limits at the left.
std::string run_chart_picture(const QuantityHistory& quantity, size_t parts,
                              const HistoryTextOptions& options);

// What the characters mean.
std::string run_chart_legend(const HistoryTextOptions& options);

}  // namespace tetragauge
