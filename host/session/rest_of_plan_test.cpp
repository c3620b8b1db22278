// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/rest_of_plan.hpp"

#include <gtest/gtest.h>

#include "firmware/scan/scan_plan.hpp"

namespace tetragauge {
namespace {

struct Aim {
  int32_t table_udeg, slide_um, a_urad, b_urad;
  uint32_t samples;
  bool operator==(const Aim&) const = default;
};

// Oracle: the firmware's own walk over a plan, beam by beam.
struct Walked {
  BeamPlace place;
  Aim aim;
};
std::vector<Walked> walk(std::span<const tg_View> views) {
  std::vector<Walked> beams;
  for (uint32_t v = 0; v < views.size(); ++v) {
    for (uint32_t ray = 0; ray < views[v].columns * views[v].rows; ++ray) {
      const RayTarget target = target_of(views[v], ray);
      beams.push_back(
          {{v, ray},
           {views[v].table_udeg, views[v].slide_um, target.a_urad, target.b_urad, views[v].samples}});
    }
  }
  return beams;
}

tg_View view_of(int32_t number, uint32_t columns, uint32_t rows) {
  tg_View view = tg_View_init_zero;
  view.table_udeg = 1000 * number;
  view.slide_um = 10 * number;
  view.a_first_urad = -50 + number;
  view.b_first_urad = 70 - number;
  view.a_step_urad = 7;
  view.b_step_urad = -3;
  view.columns = columns;
  view.rows = rows;
  view.samples = static_cast<uint32_t>(2 * number + 2);
  return view;
}

const std::vector<tg_View> kPlan{view_of(0, 3, 4), view_of(1, 1, 1), view_of(2, 4, 3), view_of(3, 5, 1)};

// `most_again`: beams measured again.
void check_rest(uint32_t max_views, size_t most_again) {
  const auto whole = walk(kPlan);
  for (size_t done = 0; done < whole.size(); ++done) {
    const RestOfPlan rest = rest_of_plan(kPlan, whole[done].place, max_views);
    EXPECT_LE(rest.views.size(), max_views);
    const auto beams = walk(rest.views);
    size_t next = done;
    size_t again = 0;
    std::optional<Aim> before;
    for (const Walked& beam : beams) {
      const auto place = place_in_whole(rest, beam.place);
      if (place && *place == whole[next].place) {
        // Each missing beam comes once, in order, aimed as in the whole plan, and from the same place.
        EXPECT_EQ(beam.aim, whole[next].aim) << "beam " << next << " after " << done;
        if (next > 0) {
          EXPECT_EQ(*before, whole[next - 1].aim) << "before beam " << next << " after " << done;
        }
        ++next;
        if (next == whole.size()) break;
      } else {
        ++again;
      }
      before = beam.aim;
    }
    EXPECT_EQ(next, whole.size()) << "after " << done;
    EXPECT_LE(again, most_again) << "after " << done;
  }
}

TEST(RestOfPlan, MissingBeamsInOrderFromWhereTheMirrorsStood) {
  check_rest(100, 1 + 2 * 4);  // the lead-in, and two rows of the widest view but one row
}

TEST(RestOfPlan, FitsAMachineThatTakesNoMoreViews) {
  check_rest(static_cast<uint32_t>(kPlan.size()), 3 * 4);  // the whole first view
}

TEST(RestOfPlan, NothingIsLeftAtTheEnd) {
  EXPECT_TRUE(rest_of_plan(kPlan, {4, 0}, 100).views.empty());
  EXPECT_TRUE(rest_of_plan(kPlan, {3, 5}, 100).views.empty());
  EXPECT_FALSE(rest_of_plan(kPlan, {3, 4}, 100).views.empty());
}

}  // namespace
}  // namespace tetragauge
