// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/rest_of_plan.hpp"

namespace tetragauge {
namespace {

uint32_t rays_of_view(const tg_View& view) {
  return view.columns * view.rows;
}

// The view's last beam before row `row`, as a view of one beam.
tg_View beam_before_row(const tg_View& view, uint32_t row) {
  tg_View one = view;
  one.columns = one.rows = 1;
  one.a_step_urad = one.b_step_urad = 0;
  const uint32_t last_row = row - 1;
  const uint32_t column = last_row % 2 == 0 ? view.columns - 1 : 0;
  one.a_first_urad += static_cast<int32_t>(column) * view.a_step_urad;
  one.b_first_urad += static_cast<int32_t>(last_row) * view.b_step_urad;
  return one;
}

}  // namespace

RestOfPlan rest_of_plan(std::span<const tg_View> whole, BeamPlace from, uint32_t max_views) {
  while (from.view < whole.size() && from.ray >= rays_of_view(whole[from.view])) from = {from.view + 1, 0};
  RestOfPlan rest;
  rest.from = from;
  if (from.view >= whole.size()) return rest;
  const tg_View& view = whole[from.view];
  uint32_t row = from.ray / view.columns / 2 * 2;
  // A plan of as many views as the machine takes has no room for a lead-in before its first view.
  if (from.view == 0 && whole.size() >= max_views) row = 0;
  if (row > 0) {
    rest.views.push_back(beam_before_row(view, row));
  } else if (from.view > 0) {
    const tg_View& before = whole[from.view - 1];
    rest.views.push_back(beam_before_row(before, before.rows));
  }
  rest.has_lead_in = !rest.views.empty();
  rest.first_ray = row * view.columns;
  tg_View first = view;
  first.b_first_urad += static_cast<int32_t>(row) * view.b_step_urad;
  first.rows -= row;
  rest.views.push_back(first);
  rest.views.insert(rest.views.end(), whole.begin() + from.view + 1, whole.end());
  return rest;
}

std::optional<BeamPlace> place_in_whole(const RestOfPlan& rest, BeamPlace in_rest) {
  if (rest.has_lead_in) {
    if (in_rest.view == 0) return std::nullopt;
    --in_rest.view;
  }
  if (in_rest.view == 0) in_rest.ray += rest.first_ray;
  in_rest.view += rest.from.view;
  return in_rest;
}

}  // namespace tetragauge
