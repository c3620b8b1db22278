// SPDX-License-Identifier: GPL-3.0-or-later
// A preview as colours: for the terminal, and as PNG.
#pragma once

#include <string>
#include <vector>

#include "host/base/encode_png.hpp"
#include "host/teach/preview.hpp"

namespace tetragauge {

enum class PreviewPicture { intensity, range };

// What the terminal can do: characters only, 256 colours, all colours.
enum class TerminalColours { none, palette, full };

// A colour per cell, rows from the top. Range: near is yellow, far is violet. The table is dark grey; a beam
// without a point is black (too little light), red (too much), orange (ambient), blue (beyond the volume) or
// magenta (beam and cameras disagree).
std::vector<Colour> paint(const Preview& preview, PreviewPicture which);

struct PreviewLinesOptions {
  TerminalColours colours = TerminalColours::none;
  size_t most_columns = 64, most_lines = 32;
  RasterWindow window{};  // what lies beyond it is shown at half its brightness
};

// One line per two rows of cells. With colours two cells stand one above the other in a half block; without,
// a character tells how bright both are (for range: how near), and nothing is shown beyond the window.
std::vector<std::string> preview_lines(const Preview& preview, PreviewPicture which,
                                       const PreviewLinesOptions& options);

// Nearest and farthest point, mm; both 0 when there is none.
struct RangeSpan {
  double near_mm = 0, far_mm = 0;
};
RangeSpan range_span(const Preview& preview);

// Intensity at the left, range at the right.
std::string preview_png(const Preview& preview);

}  // namespace tetragauge
