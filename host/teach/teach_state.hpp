// SPDX-License-Identifier: GPL-3.0-or-later
// Teaching without a terminal and without a machine: keys in, the view as it stands and the plan out.
//
//   TeachState state({.table_high_deg = 270}, reach, {});
//   state.press({KeyKind::right});              // the table 15 degrees on
//   if (state.press({KeyKind::character, 'p'}) == TeachWish::preview) state.show(take_preview(...));
//   state.press({KeyKind::character, 'k'});     // kept: state.plan() has one view more
//
// The caller does what a wish says and tells the state what came of it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/session/plan.hpp"
#include "host/session/plan_limits.hpp"
#include "host/teach/key.hpp"
#include "host/teach/preview.hpp"

namespace tetragauge {

struct TeachLimits {
  double table_low_deg = kTableLowest_deg, table_high_deg = kTableHighest_deg;
  double slide_low_mm = kSlideLowest_mm, slide_high_mm = kSlideHighest_mm;
};

enum class TeachWish { nothing, preview, save, save_and_leave, leave, reconnect, suspend };

class TeachState {
 public:
  // What the arrows move.
  enum class Target { stage, window, size };
  enum class Page { pictures, keys, leaving };  // leaving: asks whether to save

  // Whether the mirrors reach a view's window; its error is shown.
  using Reach = std::function<Status(const PlannedView&)>;

  // `plan`: views taught before.
  TeachState(TeachLimits limits, Reach reach, ScanPlan plan);

  TeachWish press(const Key& key);

  // What came of a wish.
  void show(const Preview& preview);
  void saved(const std::string& path);
  void say(const std::string& message) { message_ = message; }
  // The machine cannot be used, and why; a machine that can be.
  void lose_machine(const std::string& why);
  void find_machine(TeachLimits limits, Reach reach);

  const PlannedView& view() const { return view_; }  // where the stage is to be
  const ScanPlan& plan() const { return plan_; }
  // Each kept view's preview, where it had one from there.
  const std::vector<std::optional<Preview>>& pictures() const { return pictures_; }
  size_t selected() const { return selected_; }  // index into plan().views
  bool has_unsaved() const { return unsaved_; }
  const std::optional<Preview>& preview() const { return preview_; }
  bool preview_is_from_here() const;  // taken where the stage is to be; the window may have changed
  const std::string& message() const { return message_; }
  bool has_machine() const { return has_machine_; }
  Target target() const { return target_; }
  Page page() const { return page_; }
  double table_step_deg() const;
  double step_mm() const;  // of slide and window
  size_t beams() const;    // of the view as it stands, in full

 private:
  TeachWish press_page(const Key& key);
  TeachWish press_character(char character);
  void arrow(double right, double up);
  bool change(PlannedView view);
  void move_stage(double table_deg, double slide_mm);
  void move_window(double y_mm, double up_mm);
  void size_window(double y_mm, double up_mm);
  void change_pitch(bool finer);
  void change_samples();
  void fit_window();
  void keep();
  void drop();
  void restore();
  void select(int by);
  void go_to_selected();
  TeachWish ask_for_machine(TeachWish wish);

  TeachLimits limits_;
  Reach reach_;
  PlannedView view_;
  ScanPlan plan_;
  std::vector<std::optional<Preview>> pictures_;
  struct Dropped {
    size_t index;
    PlannedView view;
    std::optional<Preview> picture;
  };
  std::vector<Dropped> dropped_;
  size_t selected_ = 0;
  size_t step_ = 1;  // index into the steps
  bool unsaved_ = false, has_machine_ = true;
  Target target_ = Target::stage;
  Page page_ = Page::pictures;
  std::optional<Preview> preview_;
  std::string message_;
};

}  // namespace tetragauge
