// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/paint_preview.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "protocol/machine.pb.h"

namespace tetragauge {
namespace {

constexpr Colour kTable{48, 48, 48};
constexpr size_t kPngCell = 8;                    // pixels a cell is wide and high
constexpr std::string_view kRamp = " .:-=+*#%@";  // dark to bright

// Viridis (van der Walt & Smith 2015), every eighth of it: even in lightness, and seen alike by the
// colour-blind.
constexpr std::array<Colour, 9> kViridis{Colour{68, 1, 84},    Colour{71, 44, 122},  Colour{59, 81, 139},
                                         Colour{44, 113, 142}, Colour{33, 144, 141}, Colour{39, 173, 129},
                                         Colour{92, 200, 99},  Colour{170, 220, 50}, Colour{253, 231, 37}};

Colour viridis(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kViridis.size() - 1);
  const size_t low = std::min(static_cast<size_t>(at), kViridis.size() - 2);
  const double rest = at - static_cast<double>(low);
  Colour colour{};
  for (size_t c = 0; c < 3; ++c) {
    colour[c] =
        static_cast<uint8_t>(std::lround((1 - rest) * kViridis[low][c] + rest * kViridis[low + 1][c]));
  }
  return colour;
}

Colour colour_of_rejected(uint32_t reason) {
  switch (reason) {
    case tg_RejectReason_REJECT_SATURATED:
      return {200, 0, 0};
    case tg_RejectReason_REJECT_AMBIENT:
      return {220, 130, 0};
    case tg_RejectReason_REJECT_INCONSISTENT:
      return {190, 0, 190};
    case tg_RejectReason_REJECT_OUTSIDE_VOLUME:
      return {0, 0, 90};
    default:
      return {0, 0, 0};
  }
}

double strongest(const Preview& preview) {
  double most = 0;
  for (const PreviewCell& cell : preview.cells) most = std::max(most, cell.intensity);
  return most;
}

// 0 .. 1 of a point: bright, or near.
class Shade {
 public:
  Shade(const Preview& preview, PreviewPicture which)
      : which_(which), strongest_(strongest(preview)), span_(range_span(preview)) {}

  double of(const PreviewCell& cell) const {
    // Light falls off steeply on slanting faces: its root shows both.
    if (which_ == PreviewPicture::intensity)
      return strongest_ > 0 ? std::sqrt(std::max(0.0, cell.intensity) / strongest_) : 0;
    const double width = span_.far_mm - span_.near_mm;
    return width > 0 ? (span_.far_mm - cell.range_mm) / width : 0.5;
  }

 private:
  PreviewPicture which_;
  double strongest_;
  RangeSpan span_;
};

// The colour cube of xterm's 256 colours, 6 levels a channel, or its 24 greys.
int palette_index(const Colour& colour) {
  if (colour[0] == colour[1] && colour[1] == colour[2]) {
    if (colour[0] < 4) return 16;
    if (colour[0] > 246) return 231;
    return 232 + std::min(23, (colour[0] - 3) / 10);
  }
  const auto level = [](int value) { return value < 48 ? 0 : value < 115 ? 1 : (value - 35) / 40; };
  return 16 + 36 * level(colour[0]) + 6 * level(colour[1]) + level(colour[2]);
}

std::string set_colour(const Colour& colour, bool background, TerminalColours colours) {
  const std::string head = background ? "\x1b[48;" : "\x1b[38;";
  if (colours == TerminalColours::palette) return head + "5;" + std::to_string(palette_index(colour)) + "m";
  return head + "2;" + std::to_string(colour[0]) + ";" + std::to_string(colour[1]) + ";" +
         std::to_string(colour[2]) + "m";
}

// Cells are as good as evenly spaced in the aim plane.
bool contains(const RasterWindow& window, const Preview& preview, size_t column, size_t row) {
  const auto place = [](double low, double high, size_t index, size_t number) {
    return number < 2 ? 0.5 * (low + high)
                      : low + (high - low) * static_cast<double>(index) / static_cast<double>(number - 1);
  };
  const RasterWindow& whole = preview.view.window;
  const double y = place(whole.y_min_mm, whole.y_max_mm, column, preview.columns);
  const double up = place(whole.up_max_mm, whole.up_min_mm, row, preview.rows);
  constexpr double kRounding_mm = 1e-6;
  return y >= window.y_min_mm - kRounding_mm && y <= window.y_max_mm + kRounding_mm &&
         up >= window.up_min_mm - kRounding_mm && up <= window.up_max_mm + kRounding_mm;
}

char character_of(const PreviewCell& upper, const PreviewCell* lower, const Shade& shade) {
  using Kind = PreviewCell::Kind;
  double sum = 0, count = 0;
  for (const PreviewCell* cell : {&upper, lower}) {
    if (!cell || cell->kind != Kind::point) continue;
    sum += shade.of(*cell);
    count += 1;
  }
  if (count > 0) {
    // A point is never a blank.
    const double level = sum / count * static_cast<double>(kRamp.size() - 1);
    return kRamp[std::clamp<size_t>(static_cast<size_t>(std::lround(level)), 1, kRamp.size() - 1)];
  }
  if (upper.kind == Kind::table) return '_';
  return upper.reason == tg_RejectReason_REJECT_SATURATED      ? '!'
         : upper.reason == tg_RejectReason_REJECT_AMBIENT      ? 'a'
         : upper.reason == tg_RejectReason_REJECT_INCONSISTENT ? 'x'
                                                               : ' ';
}

}  // namespace

RangeSpan range_span(const Preview& preview) {
  RangeSpan span{.near_mm = 1e9, .far_mm = 0};
  for (const PreviewCell& cell : preview.cells) {
    if (cell.kind != PreviewCell::Kind::point) continue;
    span.near_mm = std::min(span.near_mm, cell.range_mm);
    span.far_mm = std::max(span.far_mm, cell.range_mm);
  }
  return span.far_mm > 0 ? span : RangeSpan{};
}

std::vector<Colour> paint(const Preview& preview, PreviewPicture which) {
  const Shade shade(preview, which);
  std::vector<Colour> pixels;
  for (const PreviewCell& cell : preview.cells) {
    if (cell.kind == PreviewCell::Kind::table) {
      pixels.push_back(kTable);
    } else if (cell.kind == PreviewCell::Kind::rejected) {
      pixels.push_back(colour_of_rejected(cell.reason));
    } else if (which == PreviewPicture::range) {
      pixels.push_back(viridis(shade.of(cell)));
    } else {
      // From 70 up: brighter than the table.
      const auto grey = static_cast<uint8_t>(std::lround(70 + 185 * shade.of(cell)));
      pixels.push_back({grey, grey, grey});
    }
  }
  return pixels;
}

std::vector<std::string> preview_lines(const Preview& preview, PreviewPicture which,
                                       const PreviewLinesOptions& options) {
  const size_t columns = std::min(preview.columns, options.most_columns);
  std::vector<Colour> pixels = paint(preview, which);
  std::vector<bool> is_inside(pixels.size());
  for (size_t k = 0; k < pixels.size(); ++k) {
    is_inside[k] = contains(options.window, preview, k % preview.columns, k / preview.columns);
    if (!is_inside[k])
      for (uint8_t& channel : pixels[k]) channel = static_cast<uint8_t>(channel / 2);
  }
  const Shade shade(preview, which);
  std::vector<std::string> lines;
  for (size_t row = 0; row < preview.rows && lines.size() < options.most_lines; row += 2) {
    const bool has_lower = row + 1 < preview.rows;
    std::string line, last;
    for (size_t column = 0; column < columns; ++column) {
      const size_t upper = row * preview.columns + column, lower = upper + preview.columns;
      if (options.colours == TerminalColours::none) {
        const bool is_seen = is_inside[upper] || (has_lower && is_inside[lower]);
        line += is_seen
                    ? character_of(preview.cells[upper], has_lower ? &preview.cells[lower] : nullptr, shade)
                    : ' ';
        continue;
      }
      std::string code = set_colour(pixels[upper], false, options.colours);
      code += has_lower ? set_colour(pixels[lower], true, options.colours) : "\x1b[49m";
      if (code != last) line += code;
      last = code;
      line += "▀";
    }
    lines.push_back(options.colours == TerminalColours::none ? line : line + "\x1b[0m");
  }
  return lines;
}

std::string preview_png(const Preview& preview) {
  if (preview.cells.empty()) return {};
  constexpr Colour kPaper{255, 255, 255};
  const std::vector<Colour> left = paint(preview, PreviewPicture::intensity);
  const std::vector<Colour> right = paint(preview, PreviewPicture::range);
  const size_t width = (2 * preview.columns + 1) * kPngCell;
  std::vector<Colour> pixels(width * preview.rows * kPngCell, kPaper);
  for (size_t y = 0; y < preview.rows * kPngCell; ++y) {
    for (size_t x = 0; x < width; ++x) {
      const size_t column = x / kPngCell, row = y / kPngCell;
      if (column < preview.columns) {
        pixels[y * width + x] = left[row * preview.columns + column];
      } else if (column > preview.columns) {
        pixels[y * width + x] = right[row * preview.columns + column - preview.columns - 1];
      }
    }
  }
  return encode_png(pixels, width);
}

}  // namespace tetragauge
