// SPDX-License-Identifier: GPL-3.0-or-later
// A quick coarse raster over a view's window, as a picture: what the machine sees from there.
//
//   auto preview = take_preview(link, view, {.columns = 40, .rows = 40});
//   preview->at(column, row).range_mm
#pragma once

#include <vector>

#include "host/session/run_scan.hpp"

namespace tetragauge {

struct PreviewCell {
  enum class Kind { table, point, rejected };
  Kind kind = Kind::table;  // a beam that met the table's top, unless said otherwise
  double intensity = 0;     // share of the converters' full scale; points only
  double range_mm = 0;      // from the last mirror; points only
  uint32_t reason = 0;      // tg_RejectReason; rejected beams only
};

// As seen from the head: columns along y to the right, rows from the top.
struct Preview {
  PlannedView view;  // what it is a picture of
  size_t columns = 0, rows = 0;
  std::vector<PreviewCell> cells;
  RasterWindow seen;  // around all points of the part, one spacing wider; only where there are any
  size_t points = 0;

  const PreviewCell& at(size_t column, size_t row) const { return cells[row * columns + column]; }
};

struct PreviewSize {
  size_t columns = 40, rows = 40;  // at most; squares
};

// Moves the stage there. ScanOptions: stop, on_progress and log are used.
Result<Preview> take_preview(Link& link, const PlannedView& view, const PreviewSize& size,
                             const ScanOptions& options = {});

}  // namespace tetragauge
