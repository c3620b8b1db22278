// SPDX-License-Identifier: GPL-3.0-or-later
// Keys in, plan out; no terminal, no machine.
#include "host/teach/teach_state.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tetragauge {
namespace {

TeachState::Reach anywhere() {
  return [](const PlannedView&) -> Status { return Done{}; };
}

class Teaching : public testing::Test {
 protected:
  // Every character of `keys` is a key; < > ^ v are the arrows, | is Tab, ~ Escape, ! Ctrl-C.
  TeachWish press(const std::string& keys) {
    TeachWish wish = TeachWish::nothing;
    for (const char c : keys) {
      const KeyKind kind = c == '<'   ? KeyKind::left
                           : c == '>' ? KeyKind::right
                           : c == '^' ? KeyKind::up
                           : c == 'v' ? KeyKind::down
                           : c == '|' ? KeyKind::tab
                           : c == '~' ? KeyKind::escape
                           : c == '!' ? KeyKind::interrupt
                                      : KeyKind::character;
      wish = state.press({kind, kind == KeyKind::character ? c : '\0'});
    }
    return wish;
  }

  Preview preview_here(size_t points = 10) const {
    Preview preview;
    preview.view = state.view();
    preview.columns = preview.rows = 2;
    preview.cells.resize(4);
    preview.points = points;
    preview.seen = {.y_min_mm = -20, .y_max_mm = 15, .up_min_mm = -30, .up_max_mm = 5};
    return preview;
  }

  TeachState state{
      TeachLimits{.table_low_deg = -90, .table_high_deg = 100, .slide_low_mm = 5, .slide_high_mm = 290},
      anywhere(),
      {}};
};

TEST_F(Teaching, ArrowsMoveTableAndSlideBySteps) {
  press(">>");
  EXPECT_EQ(state.view().table_deg, 30);
  press("<^");
  EXPECT_EQ(state.view().table_deg, 15);
  EXPECT_EQ(state.view().slide_mm, 155);
  press("->^");
  EXPECT_EQ(state.view().table_deg, 16);
  EXPECT_EQ(state.view().slide_mm, 156);
  press("---++++<");
  EXPECT_EQ(state.view().table_deg, -29);
}

TEST_F(Teaching, TheMachinesLimitsHoldAndAreSaid) {
  press("+>>>");
  EXPECT_EQ(state.view().table_deg, 100);
  EXPECT_NE(state.message().find("100 degrees"), std::string::npos) << state.message();
  press("<<<<<<");
  EXPECT_EQ(state.view().table_deg, -90);
  press("^^^^^^^^^^");
  EXPECT_EQ(state.view().slide_mm, 290);
  EXPECT_NE(state.message().find("290 mm"), std::string::npos) << state.message();
  press(std::string(30, 'v'));
  EXPECT_EQ(state.view().slide_mm, 5);
}

TEST_F(Teaching, TheWindowMovesAndGrowsWithinReach) {
  press("|>^");
  EXPECT_EQ(state.view().window.y_min_mm, -67);
  EXPECT_EQ(state.view().window.y_max_mm, 77);
  EXPECT_EQ(state.view().window.up_max_mm, 87);
  press("+>>>>>>");
  EXPECT_EQ(state.view().window.y_max_mm, kWindowReach_mm);
  EXPECT_EQ(state.view().window.y_min_mm, kWindowReach_mm - 144) << "as wide as before";
  press("|" + std::string(20, '<') + std::string(20, 'v'));
  EXPECT_GT(state.view().window.y_max_mm, state.view().window.y_min_mm);
  EXPECT_GT(state.view().window.up_max_mm, state.view().window.up_min_mm);
  press(std::string(20, '>') + std::string(20, '^'));
  EXPECT_LE(state.view().window.y_max_mm, kWindowReach_mm);
  EXPECT_GE(state.view().window.up_min_mm, -kWindowReach_mm);
  press("F");
  EXPECT_EQ(state.view().window.y_min_mm, RasterWindow{}.y_min_mm);
}

TEST_F(Teaching, WhatTheMirrorsDoNotReachIsRefused) {
  state.find_machine({}, [](const PlannedView& view) -> Status {
    if (view.window.y_max_mm > 80) return usage_error("beyond the mirrors");
    return Done{};
  });
  press("|>");
  EXPECT_EQ(state.view().window.y_max_mm, 77);
  press(">");
  EXPECT_EQ(state.view().window.y_max_mm, 77);
  EXPECT_EQ(state.message(), "beyond the mirrors");
}

TEST_F(Teaching, KeepDropAndBringBack) {
  press("k>k>k");
  ASSERT_EQ(state.plan().views.size(), 3u);
  EXPECT_EQ(state.selected(), 2u);
  press("[d");
  ASSERT_EQ(state.plan().views.size(), 2u);
  EXPECT_EQ(state.plan().views[1].table_deg, 30);
  press("dd");
  EXPECT_TRUE(state.plan().views.empty());
  press("d");
  EXPECT_TRUE(state.plan().views.empty());
  press("uuu");
  ASSERT_EQ(state.plan().views.size(), 3u);
  for (size_t k = 0; k < 3; ++k) EXPECT_EQ(state.plan().views[k].table_deg, 15.0 * static_cast<double>(k));
  press("u");
  EXPECT_EQ(state.plan().views.size(), 3u);
}

TEST_F(Teaching, TheSameViewIsKeptOnce) {
  press("kk");
  EXPECT_EQ(state.plan().views.size(), 1u);
  press(",k");
  EXPECT_EQ(state.plan().views.size(), 2u) << "another pitch is another view";
}

TEST_F(Teaching, GoToAKeptView) {
  press("k>>^|>k[g");
  EXPECT_EQ(state.view().table_deg, 0);
  EXPECT_EQ(state.view().slide_mm, 150);
  EXPECT_EQ(state.view().window.y_min_mm, RasterWindow{}.y_min_mm);
}

TEST_F(Teaching, PitchAndSamples) {
  press(",");
  EXPECT_EQ(state.view().pitch_mm, 0.5);
  press(",,,,");
  EXPECT_EQ(state.view().pitch_mm, 0.25);
  press("........");
  EXPECT_EQ(state.view().pitch_mm, 4);
  const uint32_t before = state.view().samples;
  press("a");
  EXPECT_NE(state.view().samples, before);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(state.view().samples % 2, 0u) << "a plan wants them even";
    press("a");
  }
  EXPECT_EQ(state.view().samples, before);
}

TEST_F(Teaching, ThePreviewBelongsToItsPlace) {
  EXPECT_EQ(press(" "), TeachWish::preview);
  state.show(preview_here());
  EXPECT_TRUE(state.preview_is_from_here());
  press("f");
  EXPECT_EQ(state.view().window.y_max_mm, 15);
  press("k");
  EXPECT_TRUE(state.pictures().at(0).has_value());
  press(">");
  EXPECT_FALSE(state.preview_is_from_here());
  const RasterWindow before = state.view().window;
  press("f");
  EXPECT_EQ(state.view().window.up_max_mm, before.up_max_mm) << "a picture from elsewhere fits nothing";
  press("k");
  EXPECT_FALSE(state.pictures().at(1).has_value());
}

TEST_F(Teaching, APreviewOfTheTableAloneFitsNothing) {
  state.show(preview_here(0));
  press("f");
  EXPECT_EQ(state.view().window.y_max_mm, RasterWindow{}.y_max_mm);
}

TEST_F(Teaching, LeavingAsksOnlyForWhatIsNotSaved) {
  EXPECT_EQ(press("q"), TeachWish::leave);
  press("k");
  EXPECT_TRUE(state.has_unsaved());
  EXPECT_EQ(press("!"), TeachWish::nothing);
  EXPECT_EQ(state.page(), TeachState::Page::leaving);
  EXPECT_EQ(press("x!k "), TeachWish::nothing) << "no clear answer";
  EXPECT_EQ(state.plan().views.size(), 1u);
  EXPECT_EQ(press("~"), TeachWish::nothing);
  EXPECT_EQ(state.page(), TeachState::Page::pictures);
  EXPECT_EQ(press("qy"), TeachWish::save_and_leave);
  EXPECT_EQ(press("s"), TeachWish::save);
  state.saved("plan.json");
  EXPECT_EQ(press("q"), TeachWish::leave);
  press("d");
  EXPECT_EQ(press("qn"), TeachWish::leave) << "dropping is a change, too";
}

TEST_F(Teaching, NothingIsLostWithTheMachine) {
  press("k>k");
  state.lose_machine("the cable was pulled");
  EXPECT_NE(state.message().find("2 views kept"), std::string::npos) << state.message();
  EXPECT_NE(state.message().find("the cable was pulled"), std::string::npos);
  EXPECT_EQ(press(" "), TeachWish::nothing);
  EXPECT_EQ(press("s"), TeachWish::save);
  EXPECT_EQ(press("r"), TeachWish::reconnect);
  EXPECT_EQ(state.plan().views.size(), 2u);
  state.find_machine({}, anywhere());
  EXPECT_EQ(press(" "), TeachWish::preview);
}

TEST_F(Teaching, HelpEndsWithAnyKey) {
  press("k?");
  EXPECT_EQ(state.page(), TeachState::Page::keys);
  press("d");
  EXPECT_EQ(state.page(), TeachState::Page::pictures);
  EXPECT_EQ(state.plan().views.size(), 1u) << "that key did nothing else";
}

// Whatever is typed, what is kept can be read as a plan.
TEST_F(Teaching, AnyKeysGiveAPlanWithinItsLimits) {
  std::mt19937 random(7);
  const std::string keys = "<>^v|+-,.afFkdu[]g~?sr ";
  for (int k = 0; k < 20'000; ++k) {
    press(std::string(1, keys[random() % keys.size()]));
    if (k % 50 == 0) state.show(preview_here());
  }
  press("~~k");
  for (const PlannedView& view : state.plan().views) {
    EXPECT_GE(view.table_deg, -90);
    EXPECT_LE(view.table_deg, 100);
    EXPECT_GE(view.slide_mm, 5);
    EXPECT_LE(view.slide_mm, 290);
    EXPECT_LT(view.window.y_min_mm, view.window.y_max_mm);
    EXPECT_LT(view.window.up_min_mm, view.window.up_max_mm);
    for (const double edge :
         {view.window.y_min_mm, view.window.y_max_mm, view.window.up_min_mm, view.window.up_max_mm})
      EXPECT_LE(std::abs(edge), kWindowReach_mm);
  }
}

}  // namespace
}  // namespace tetragauge
