// SPDX-License-Identifier: GPL-3.0-or-later
// The screen of a teaching session as text.
#pragma once

#include <string>

#include "host/teach/paint_preview.hpp"
#include "host/teach/teach_state.hpp"

namespace tetragauge {

struct ScreenFacts {
  size_t columns = 80, rows = 24;
  TerminalColours colours = TerminalColours::none;
  std::string plan{};                  // file name
  std::string machine{};               // what it is
  std::string doing{};                 // "homing", "preview 40 %"; "": nothing
  double table_deg = 0, slide_mm = 0;  // where the stage is
};

inline constexpr size_t kFewestColumns = 80, kFewestRows = 24;

// `facts.rows` lines, none wider than `facts.columns`. In a terminal that is too small: a line that says so.
std::vector<std::string> draw_screen(const TeachState& state, const ScreenFacts& facts);

// How large a preview fits.
PreviewSize preview_size(const ScreenFacts& facts);

// The keys, a line each; also the command's help.
std::vector<std::string> key_table();

}  // namespace tetragauge
