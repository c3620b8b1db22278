// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/draw_screen.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tetragauge {
namespace {

constexpr size_t kListColumns = 26;
// Title, head of the pictures, a blank, three lines of numbers, a blank, the message, keys.
constexpr size_t kMessageLines = 3, kOtherLines = 8 + kMessageLines;

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[240];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

// To exactly so many columns; `text` has no control codes, and one byte a column.
std::string fill(std::string text, size_t columns) {
  text.resize(columns, ' ');
  return text;
}

std::string bold(const std::string& text, bool wanted, TerminalColours colours) {
  if (!wanted) return text;
  return colours == TerminalColours::none ? text : "\x1b[1m" + text + "\x1b[0m";
}

std::string title(const TeachState& state, const ScreenFacts& facts) {
  const size_t views = state.plan().views.size();
  std::string left = " teach " + facts.plan + print(": %zu view%s", views, views == 1 ? "" : "s") +
                     (state.has_unsaved() ? ", not saved" : "");
  std::string right = facts.machine + ": " +
                      (!state.has_machine()  ? "NOT READY"
                       : facts.doing.empty() ? "ready"
                                             : facts.doing) +
                      " ";
  if (left.size() + right.size() + 1 > facts.columns) {
    const size_t room = facts.columns > right.size() + 1 ? facts.columns - right.size() - 1 : 0;
    left = left.substr(0, room);
  }
  std::string line = fill(left, facts.columns - std::min(facts.columns, right.size())) + right;
  line = fill(line, facts.columns);
  if (facts.colours == TerminalColours::none) return line;
  return (state.has_machine() ? "\x1b[7m" : "\x1b[7;31m") + line + "\x1b[0m";
}

// The list of kept views, those around the selected one when not all fit.
std::vector<std::string> list_lines(const TeachState& state, size_t lines) {
  std::vector<std::string> text;
  const auto& views = state.plan().views;
  const size_t first =
      views.size() <= lines
          ? 0
          : std::min(views.size() - lines, state.selected() - std::min(state.selected(), lines / 2));
  for (size_t k = first; k < views.size() && text.size() < lines; ++k) {
    text.push_back(print("%c%3zu %+7.1f %6.1f %5.4g", k == state.selected() ? '>' : ' ', k + 1,
                         views[k].table_deg, views[k].slide_mm, views[k].pitch_mm));
  }
  if (views.empty()) text.push_back("  none kept yet (k)");
  return text;
}

std::string stage_line(const TeachState& state, const ScreenFacts& facts) {
  const PlannedView& view = state.view();
  std::string line = print("table %+7.1f deg", view.table_deg);
  if (std::abs(view.table_deg - facts.table_deg) > 0.05) line += print(" (now %+.1f)", facts.table_deg);
  line = fill(line, 34) + print("slide %6.1f mm", view.slide_mm);
  if (std::abs(view.slide_mm - facts.slide_mm) > 0.05) line += print(" (now %.1f)", facts.slide_mm);
  return line;
}

std::string window_line(const TeachState& state) {
  const PlannedView& view = state.view();
  const RasterWindow& w = view.window;
  return fill(print("window y %g .. %g, up %g .. %g mm", w.y_min_mm, w.y_max_mm, w.up_min_mm, w.up_max_mm),
              44) +
         print(" pitch %g mm, %u samples: %zu beams", view.pitch_mm, static_cast<unsigned>(view.samples),
               state.beams());
}

std::string target_line(const TeachState& state, const ScreenFacts& facts) {
  using Target = TeachState::Target;
  const auto choice = [&](Target target, const char* name) {
    const bool is_it = state.target() == target;
    return bold(is_it ? "[" + std::string(name) + "]" : " " + std::string(name) + " ", is_it, facts.colours);
  };
  return "arrows move (tab): " + choice(Target::stage, "stage") + choice(Target::window, "window") +
         choice(Target::size, "window's size") +
         print("   steps (+ -): %g deg, %g mm", state.table_step_deg(), state.step_mm());
}

std::string range_head(const TeachState& state) {
  if (!state.preview()) return "range";
  const RangeSpan span = range_span(*state.preview());
  return span.far_mm > 0 ? print("range %.0f .. %.0f mm", span.near_mm, span.far_mm) : "range";
}

std::vector<std::string> picture_page(const TeachState& state, const ScreenFacts& facts) {
  const size_t lines = facts.rows - kOtherLines;
  const size_t width = (facts.columns - kListColumns - 3) / 2;
  std::vector<std::string> screen;
  const bool is_old = state.preview() && !state.preview_is_from_here();
  screen.push_back(
      fill(state.preview() ? (is_old ? "intensity (elsewhere)" : "intensity") : "no preview yet", width) +
      " " + fill(state.preview() ? range_head(state) : "", width) + "  " +
      fill("view   table  slide pitch", kListColumns));
  std::vector<std::string> left, right;
  size_t shown = 0;  // columns of a picture
  if (state.preview()) {
    // A picture from elsewhere has nothing to do with the window.
    const PreviewLinesOptions options{
        .colours = facts.colours,
        .most_columns = width,
        .most_lines = lines,
        .window = state.preview_is_from_here() ? state.view().window : state.preview()->view.window};
    left = preview_lines(*state.preview(), PreviewPicture::intensity, options);
    right = preview_lines(*state.preview(), PreviewPicture::range, options);
    shown = std::min(width, state.preview()->columns);
  }
  const std::vector<std::string> list = list_lines(state, lines);
  const std::string gap(width - shown, ' '), empty(width, ' ');
  for (size_t k = 0; k < lines; ++k) {
    std::string line = k < left.size() ? left[k] + gap : empty;
    line += " ";
    line += k < right.size() ? right[k] + gap : empty;
    if (k < list.size()) {
      line += "  " + bold(list[k], list[k].starts_with('>'), facts.colours);
    }
    screen.push_back(line);
  }
  return screen;
}

// Cut where it does not fit.
std::vector<std::string> message_lines(const std::string& message, size_t columns) {
  std::vector<std::string> lines(kMessageLines);
  size_t at = 0, line = 0;
  while (at < message.size() && line < lines.size()) {
    size_t end = message.find_first_of(" \n", at);
    if (end == std::string::npos) end = message.size();
    const std::string word = message.substr(at, end - at);
    if (!lines[line].empty() && lines[line].size() + 1 + word.size() > columns) {
      ++line;
      continue;
    }
    lines[line] += (lines[line].empty() ? "" : " ") + word;
    at = end + 1;
  }
  for (std::string& text : lines) text = text.substr(0, columns);
  return lines;
}

std::vector<std::string> leaving_lines(const TeachState& state, const ScreenFacts& facts) {
  const size_t views = state.plan().views.size();
  return {bold(print("Save %zu view%s to ", views, views == 1 ? "" : "s") + facts.plan + "?", true,
               facts.colours),
          "y or Enter: save and leave    n: leave without saving    Esc: go on teaching", ""};
}

}  // namespace

PreviewSize preview_size(const ScreenFacts& facts) {
  // More than this takes longer than one likes to wait.
  constexpr size_t kMost = 64;
  const size_t columns = std::max(facts.columns, kFewestColumns), rows = std::max(facts.rows, kFewestRows);
  return {.columns = std::min(kMost, (columns - kListColumns - 3) / 2),
          .rows = std::min(kMost, 2 * (rows - kOtherLines))};
}

std::vector<std::string> key_table() {
  return {"arrows      left, right: the table; up, down: the slide; or what tab says",
          "tab         what the arrows move: the stage, the window, the window's size",
          "+ -         larger or smaller steps",
          "space, p    preview: a quick coarse raster; Esc stops it",
          "f           fit the window to what the preview shows of the part",
          "F           the whole window",
          ", .         finer or coarser pitch of the scan",
          "a           samples a beam, in turn",
          "k, Enter    keep the view in the plan",
          "[ ]         select a kept view",
          "g           go to the selected view",
          "d           drop the selected view; u brings it back",
          "s           save the plan",
          "r           get a lost machine back: clear its fault, home, connect again",
          "?           these keys",
          "q, Ctrl-C   leave; asks when something is not saved"};
}

std::vector<std::string> draw_screen(const TeachState& state, const ScreenFacts& facts) {
  if (facts.columns < kFewestColumns || facts.rows < kFewestRows) {
    std::vector<std::string> screen(std::max<size_t>(facts.rows, 1));
    screen[0] =
        print("make the terminal at least %zu x %zu", kFewestColumns, kFewestRows).substr(0, facts.columns);
    return screen;
  }
  std::vector<std::string> screen{title(state, facts)};
  if (state.page() == TeachState::Page::keys) {
    screen.push_back("");
    for (const std::string& line : key_table()) screen.push_back("  " + line);
    screen.push_back("");
    screen.push_back("  Pictures: the table is grey. No point: black too little light, red too much,");
    screen.push_back("  orange ambient light, blue beyond the volume, magenta beam and cameras differ.");
    screen.push_back("  Any key goes back.");
    screen.resize(facts.rows);
    return screen;
  }
  for (std::string& line : picture_page(state, facts)) screen.push_back(std::move(line));
  screen.push_back("");
  screen.push_back(stage_line(state, facts));
  screen.push_back(window_line(state));
  screen.push_back(target_line(state, facts));
  screen.push_back("");
  const bool asks = state.page() == TeachState::Page::leaving;
  for (std::string& line : asks ? leaving_lines(state, facts) : message_lines(state.message(), facts.columns))
    screen.push_back(std::move(line));
  screen.push_back("space preview  k keep  [ ] select  g go to  d drop  s save  ? all keys  q leave");
  // A picture is lower than its room: what comes below stays in its place all the same.
  screen.resize(facts.rows);
  return screen;
}

}  // namespace tetragauge
