// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/draw_screen.hpp"

#include <gtest/gtest.h>

#include "protocol/machine.pb.h"

namespace tetragauge {
namespace {

TeachState some_state(size_t views) {
  ScanPlan plan;
  for (size_t k = 0; k < views; ++k)
    plan.views.push_back({.table_deg = static_cast<double>(k), .slide_mm = 150, .window = {}});
  return {{}, [](const PlannedView&) -> Status { return Done{}; }, plan};
}

// A slope from near (left) to far, dark to bright; one beam each of the table, too little and too much light.
Preview slope(const PlannedView& view) {
  Preview preview;
  preview.view = view;
  preview.columns = 6;
  preview.rows = 4;
  for (size_t k = 0; k < 24; ++k) {
    const double column = static_cast<double>(k % 6);
    preview.cells.push_back(
        {.kind = PreviewCell::Kind::point, .intensity = 0.01 + 0.1 * column, .range_mm = 300 + 10 * column});
  }
  preview.cells[0] = {};
  preview.cells[6] = {};
  preview.cells[12] = {.kind = PreviewCell::Kind::rejected, .reason = tg_RejectReason_REJECT_WEAK};
  preview.cells[18] = {.kind = PreviewCell::Kind::rejected, .reason = tg_RejectReason_REJECT_SATURATED};
  preview.points = 20;
  return preview;
}

size_t columns_of(const std::string& line) {
  size_t columns = 0;
  bool in_code = false;
  for (const char c : line) {
    if (c == '\x1b') in_code = true;
    if (!in_code && (static_cast<unsigned char>(c) & 0xC0) != 0x80) ++columns;
    if (in_code && c == 'm') in_code = false;
  }
  return columns;
}

TEST(DrawScreen, FitsEveryTerminal) {
  for (const size_t views : {0u, 3u, 200u}) {
    TeachState state = some_state(views);
    state.show(slope(state.view()));
    state.say(std::string(500, 'm') + " and " + std::string(300, 'n'));
    for (const auto& [columns, rows] :
         {std::pair<size_t, size_t>{80, 24}, {100, 30}, {237, 71}, {40, 10}, {1, 1}}) {
      for (const TerminalColours colours :
           {TerminalColours::none, TerminalColours::palette, TerminalColours::full}) {
        ScreenFacts facts{.columns = columns, .rows = rows, .colours = colours};
        facts.plan = std::string(120, 'p');
        facts.machine = "emulated";
        for (const char key : {'~', '?'}) {
          state.press({KeyKind::character, key});
          const std::vector<std::string> screen = draw_screen(state, facts);
          EXPECT_EQ(screen.size(), rows);
          for (const std::string& line : screen) EXPECT_LE(columns_of(line), columns) << line;
          if (colours != TerminalColours::none) continue;
          for (const std::string& line : screen) EXPECT_EQ(line.find('\x1b'), std::string::npos);
        }
        state.press({KeyKind::escape});
      }
    }
  }
}

TEST(DrawScreen, TheSelectedViewIsInSight) {
  TeachState state = some_state(200);
  for (int k = 0; k < 60; ++k) state.press({KeyKind::character, '['});
  std::string all;
  for (const std::string& line : draw_screen(state, {.columns = 80, .rows = 24})) all += line + "\n";
  EXPECT_NE(all.find(">140"), std::string::npos) << all;
}

TEST(PaintPreview, NearIsBrightAndRejectsAreTold) {
  const TeachState state = some_state(0);
  const Preview preview = slope(state.view());
  const PreviewLinesOptions options;
  const auto intensity = preview_lines(preview, PreviewPicture::intensity, options);
  const auto range = preview_lines(preview, PreviewPicture::range, options);
  ASSERT_EQ(intensity.size(), 2u);
  EXPECT_EQ(intensity[0][0], '_') << "the table";
  EXPECT_EQ(intensity[1][0], ' ') << "too little light";
  EXPECT_EQ(intensity[0][5], '@') << "brightest";
  EXPECT_EQ(range[0][5], '.') << "farthest, and yet no blank";
  EXPECT_EQ(range_span(preview).near_mm, 310);
  EXPECT_EQ(range_span(preview).far_mm, 350);
  const std::vector<Colour> colours = paint(preview, PreviewPicture::range);
  EXPECT_EQ(colours[1], (Colour{253, 231, 37})) << "nearest: viridis' yellow";
  EXPECT_EQ(colours[5], (Colour{68, 1, 84})) << "farthest: viridis' violet";
  EXPECT_EQ(colours[18], (Colour{200, 0, 0})) << "too much light";
}

TEST(PaintPreview, BeyondTheWindowNothingIsShown) {
  const TeachState state = some_state(0);
  Preview preview = slope(state.view());
  // The right half: columns 3 to 5 of y -72 .. 72.
  const auto lines =
      preview_lines(preview, PreviewPicture::intensity, {.window = {.y_min_mm = 0, .y_max_mm = 72}});
  EXPECT_EQ(lines[0].substr(0, 3), "   ");
  EXPECT_NE(lines[0][3], ' ');
}

TEST(PaintPreview, PngHasBothPictures) {
  const TeachState state = some_state(0);
  const std::string png = preview_png(slope(state.view()));
  ASSERT_GT(png.size(), 24u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  // Width and height in the header, big-endian: (2 * 6 + 1) * 8 and 4 * 8 pixels.
  EXPECT_EQ(png.substr(16, 8), std::string("\0\0\0\x68\0\0\0\x20", 8));
  EXPECT_TRUE(preview_png({}).empty());
}

}  // namespace
}  // namespace tetragauge
