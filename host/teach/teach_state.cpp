// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/teach_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace tetragauge {
namespace {

struct Step {
  double table_deg, mm;
};
constexpr std::array kSteps{Step{1, 1}, Step{15, 5}, Step{45, 20}};
constexpr std::array kPitches_mm{0.25, 0.5, 1.0, 2.0, 4.0};
constexpr std::array kSamples{uint32_t{8}, uint32_t{16}, uint32_t{36}, uint32_t{72}, uint32_t{144}};
constexpr double kSmallestWindow_mm = 2;
// A part in the middle of the working volume, 200 mm high, is in the middle of the window.
constexpr double kMiddle_mm = 150;

std::string text_of(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%g%s", value, unit);
  return text;
}

std::string number_of_views(size_t views) {
  return std::to_string(views) + (views == 1 ? " view" : " views");
}

}  // namespace

TeachState::TeachState(TeachLimits limits, Reach reach, ScanPlan plan)
    : limits_(limits), reach_(std::move(reach)), plan_(std::move(plan)), pictures_(plan_.views.size()) {
  view_.slide_mm = kMiddle_mm;
  view_.table_deg = 0;
  if (!plan_.views.empty()) {
    selected_ = plan_.views.size() - 1;
    view_ = plan_.views.back();
  }
  message_ = plan_.views.empty() ? "space takes a preview, k keeps the view, ? shows all keys"
                                 : number_of_views(plan_.views.size()) + " taught before; teaching goes on";
}

double TeachState::table_step_deg() const {
  return kSteps[step_].table_deg;
}

double TeachState::step_mm() const {
  return kSteps[step_].mm;
}

size_t TeachState::beams() const {
  const auto count = [&](double span_mm) {
    return static_cast<size_t>(std::floor(span_mm / view_.pitch_mm + 1e-9)) + 1;
  };
  const RasterWindow& w = view_.window;
  return count(w.y_max_mm - w.y_min_mm) * count(w.up_max_mm - w.up_min_mm);
}

bool TeachState::preview_is_from_here() const {
  return preview_ && preview_->view.table_deg == view_.table_deg && preview_->view.slide_mm == view_.slide_mm;
}

void TeachState::show(const Preview& preview) {
  preview_ = preview;
  message_ = preview.points > 0 ? std::to_string(preview.points) +
                                      " points of the part; f fits the window to it, k keeps the view"
                                : "nothing but the table in sight: turn the table, move the slide or widen "
                                  "the window (F)";
}

void TeachState::saved(const std::string& path) {
  unsaved_ = false;
  message_ = path + " saved: " + number_of_views(plan_.views.size());
}

void TeachState::lose_machine(const std::string& why) {
  has_machine_ = false;
  const std::string views =
      plan_.views.empty() ? "" : "; " + number_of_views(plan_.views.size()) + " kept: s saves";
  message_ = "NO MACHINE (r tries again" + views + "): " + why;
}

void TeachState::find_machine(TeachLimits limits, Reach reach) {
  limits_ = limits;
  reach_ = std::move(reach);
  has_machine_ = true;
}

TeachWish TeachState::ask_for_machine(TeachWish wish) {
  if (has_machine_) return wish;
  message_ = "there is no machine to do that; r tries to get it back";
  return TeachWish::nothing;
}

TeachWish TeachState::press(const Key& key) {
  if (page_ != Page::pictures) return press_page(key);
  switch (key.kind) {
    case KeyKind::left:
      arrow(-1, 0);
      return TeachWish::nothing;
    case KeyKind::right:
      arrow(1, 0);
      return TeachWish::nothing;
    case KeyKind::up:
      arrow(0, 1);
      return TeachWish::nothing;
    case KeyKind::down:
      arrow(0, -1);
      return TeachWish::nothing;
    case KeyKind::tab:
      target_ = target_ == Target::stage    ? Target::window
                : target_ == Target::window ? Target::size
                                            : Target::stage;
      message_ = target_ == Target::stage    ? "arrows: table and slide"
                 : target_ == Target::window ? "arrows: move the window"
                                             : "arrows: size of the window";
      return TeachWish::nothing;
    case KeyKind::enter:
      keep();
      return TeachWish::nothing;
    case KeyKind::interrupt:
      return press_character('q');
    case KeyKind::suspend:
      return TeachWish::suspend;
    case KeyKind::escape:
      message_.clear();
      return TeachWish::nothing;
    case KeyKind::character:
      return press_character(key.character);
  }
  return TeachWish::nothing;
}

TeachWish TeachState::press_page(const Key& key) {
  if (key.kind == KeyKind::suspend) return TeachWish::suspend;
  if (page_ == Page::keys) {
    page_ = Page::pictures;
    return TeachWish::nothing;
  }
  // Asked whether to save. Only a clear answer counts; a second Ctrl-C is none.
  if (key == Key{KeyKind::character, 'y'} || key.kind == KeyKind::enter) {
    page_ = Page::pictures;
    return TeachWish::save_and_leave;
  }
  if (key == Key{KeyKind::character, 'n'}) return TeachWish::leave;
  if (key.kind == KeyKind::escape) {
    page_ = Page::pictures;
    message_ = "teaching goes on";
  }
  return TeachWish::nothing;
}

TeachWish TeachState::press_character(char character) {
  switch (character) {
    case ' ':
    case 'p':
      return ask_for_machine(TeachWish::preview);
    case 'k':
      keep();
      break;
    case 'd':
      drop();
      break;
    case 'u':
      restore();
      break;
    case '[':
      select(-1);
      break;
    case ']':
      select(1);
      break;
    case 'g':
      go_to_selected();
      break;
    case '+':
    case '=':
    case '-': {
      const bool larger = character != '-';
      step_ = larger ? std::min(step_ + 1, kSteps.size() - 1) : step_ - std::min<size_t>(step_, 1);
      message_ = "steps: " + text_of(table_step_deg(), " degrees, ") + text_of(step_mm(), " mm");
      break;
    }
    case ',':
      change_pitch(true);
      break;
    case '.':
      change_pitch(false);
      break;
    case 'a':
      change_samples();
      break;
    case 'f':
      fit_window();
      break;
    case 'F': {
      PlannedView whole = view_;
      whole.window = RasterWindow{};
      if (change(whole)) message_ = "the whole window";
      break;
    }
    case 's':
      return TeachWish::save;
    case 'r':
      return TeachWish::reconnect;
    case '?':
    case 'h':
      page_ = Page::keys;
      break;
    case 'q':
      if (!unsaved_) return TeachWish::leave;
      page_ = Page::leaving;
      break;
    default:
      break;
  }
  return TeachWish::nothing;
}

void TeachState::arrow(double right, double up) {
  switch (target_) {
    case Target::stage:
      move_stage(right * table_step_deg(), up * step_mm());
      break;
    case Target::window:
      move_window(right * step_mm(), up * step_mm());
      break;
    case Target::size:
      size_window(right * step_mm(), up * step_mm());
      break;
  }
}

bool TeachState::change(PlannedView view) {
  if (const Status done = reach_(view); !done) {
    message_ = done.error().message;
    return false;
  }
  view_ = view;
  message_.clear();
  return true;
}

void TeachState::move_stage(double table_deg, double slide_mm) {
  PlannedView to = view_;
  to.table_deg = std::clamp(view_.table_deg + table_deg, limits_.table_low_deg, limits_.table_high_deg);
  to.slide_mm = std::clamp(view_.slide_mm + slide_mm, limits_.slide_low_mm, limits_.slide_high_mm);
  const bool cut = to.table_deg != view_.table_deg + table_deg || to.slide_mm != view_.slide_mm + slide_mm;
  if (!change(to) || !cut) return;
  message_ = table_deg != 0 ? "the table ends at " + text_of(to.table_deg, " degrees")
                            : "the slide ends at " + text_of(to.slide_mm, " mm");
}

void TeachState::move_window(double y_mm, double up_mm) {
  PlannedView to = view_;
  RasterWindow& w = to.window;
  // As far as it goes without becoming smaller.
  y_mm = std::clamp(y_mm, -kWindowReach_mm - w.y_min_mm, kWindowReach_mm - w.y_max_mm);
  up_mm = std::clamp(up_mm, -kWindowReach_mm - w.up_min_mm, kWindowReach_mm - w.up_max_mm);
  w = {w.y_min_mm + y_mm, w.y_max_mm + y_mm, w.up_min_mm + up_mm, w.up_max_mm + up_mm};
  change(to);
}

void TeachState::size_window(double y_mm, double up_mm) {
  PlannedView to = view_;
  // About its middle, within what the mirrors reach.
  const auto widen = [](double by, double& low, double& high) {
    const double half = std::max(0.5 * (high - low) + by, 0.5 * kSmallestWindow_mm);
    const double middle = 0.5 * (low + high);
    low = std::max(middle - half, -kWindowReach_mm);
    high = std::min(middle + half, kWindowReach_mm);
  };
  if (y_mm != 0) widen(y_mm, to.window.y_min_mm, to.window.y_max_mm);
  if (up_mm != 0) widen(up_mm, to.window.up_min_mm, to.window.up_max_mm);
  change(to);
}

void TeachState::change_pitch(bool finer) {
  PlannedView to = view_;
  if (finer) {
    const auto next = std::lower_bound(kPitches_mm.begin(), kPitches_mm.end(), view_.pitch_mm);
    if (next != kPitches_mm.begin()) to.pitch_mm = *(next - 1);
  } else {
    const auto next = std::upper_bound(kPitches_mm.begin(), kPitches_mm.end(), view_.pitch_mm);
    if (next != kPitches_mm.end()) to.pitch_mm = *next;
  }
  if (change(to)) message_ = "pitch " + text_of(view_.pitch_mm, " mm");
}

void TeachState::change_samples() {
  const auto next = std::upper_bound(kSamples.begin(), kSamples.end(), view_.samples);
  view_.samples = next == kSamples.end() ? kSamples.front() : *next;
  message_ = std::to_string(view_.samples) + " samples a beam";
}

void TeachState::fit_window() {
  if (!preview_is_from_here() || preview_->points == 0) {
    message_ = preview_is_from_here() ? "the preview shows nothing of the part"
                                      : "take a preview here first (space)";
    return;
  }
  PlannedView to = view_;
  to.window = preview_->seen;
  if (change(to)) message_ = "window fitted to what the preview shows of the part";
}

void TeachState::keep() {
  for (size_t k = 0; k < plan_.views.size(); ++k) {
    const PlannedView &a = plan_.views[k], &b = view_;
    if (a.table_deg == b.table_deg && a.slide_mm == b.slide_mm && a.pitch_mm == b.pitch_mm &&
        a.samples == b.samples && a.window.y_min_mm == b.window.y_min_mm &&
        a.window.y_max_mm == b.window.y_max_mm && a.window.up_min_mm == b.window.up_min_mm &&
        a.window.up_max_mm == b.window.up_max_mm) {
      selected_ = k;
      message_ = "that is view " + std::to_string(k + 1) + " already";
      return;
    }
  }
  plan_.views.push_back(view_);
  pictures_.push_back(preview_is_from_here() ? preview_ : std::nullopt);
  selected_ = plan_.views.size() - 1;
  unsaved_ = true;
  message_ = "kept as view " + std::to_string(plan_.views.size());
}

void TeachState::drop() {
  if (plan_.views.empty()) {
    message_ = "there is no view to drop";
    return;
  }
  const auto at = static_cast<std::ptrdiff_t>(selected_);
  dropped_.push_back({selected_, plan_.views[selected_], std::move(pictures_[selected_])});
  plan_.views.erase(plan_.views.begin() + at);
  pictures_.erase(pictures_.begin() + at);
  message_ = "view " + std::to_string(selected_ + 1) + " dropped; u brings it back";
  selected_ = std::min(selected_, plan_.views.empty() ? 0 : plan_.views.size() - 1);
  unsaved_ = true;
}

void TeachState::restore() {
  if (dropped_.empty()) {
    message_ = "nothing was dropped";
    return;
  }
  Dropped last = std::move(dropped_.back());
  dropped_.pop_back();
  selected_ = std::min(last.index, plan_.views.size());
  const auto at = static_cast<std::ptrdiff_t>(selected_);
  plan_.views.insert(plan_.views.begin() + at, last.view);
  pictures_.insert(pictures_.begin() + at, std::move(last.picture));
  unsaved_ = true;
  message_ = "view " + std::to_string(selected_ + 1) + " is back";
}

void TeachState::select(int by) {
  if (plan_.views.empty()) {
    message_ = "no view is kept yet";
    return;
  }
  const size_t last = plan_.views.size() - 1;
  if (by < 0) selected_ = selected_ == 0 ? last : selected_ - 1;
  if (by > 0) selected_ = selected_ == last ? 0 : selected_ + 1;
  message_ = "view " + std::to_string(selected_ + 1) + " selected: g goes there, d drops it";
}

void TeachState::go_to_selected() {
  if (plan_.views.empty()) {
    message_ = "no view is kept yet";
    return;
  }
  if (!change(plan_.views[selected_])) return;
  if (pictures_[selected_]) preview_ = pictures_[selected_];
  message_ = "as view " + std::to_string(selected_ + 1);
}

}  // namespace tetragauge
