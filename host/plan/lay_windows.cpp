// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/lay_windows.hpp"

#include <algorithm>
#include <cmath>

#include "host/session/plan_limits.hpp"

namespace tetragauge {
namespace {

// A window reaches this share of a pitch beyond its spots, so that some ray comes within half a pitch.
constexpr double kMarginPitches = 0.5;

struct Box {
  double y_min = 1e9, y_max = -1e9, up_min = 1e9, up_max = -1e9;

  void add(const WindowSpot& spot) {
    y_min = std::min(y_min, spot.y_mm - spot.reach_mm);
    y_max = std::max(y_max, spot.y_mm + spot.reach_mm);
    up_min = std::min(up_min, spot.up_mm - spot.reach_mm);
    up_max = std::max(up_max, spot.up_mm + spot.reach_mm);
  }
  RasterWindow window(double pitch_mm) const {
    const double margin = kMarginPitches * pitch_mm;
    // Tenths, outwards: a plan is read by people.
    const auto down = [](double x) { return std::max(-kWindowReach_mm, std::floor(10 * x) / 10); };
    const auto up = [](double x) { return std::min(kWindowReach_mm, std::ceil(10 * x) / 10); };
    return {down(y_min - margin), up(y_max + margin), down(up_min - margin), up(up_max + margin)};
  }
  double time_s(const RasterCost& cost) const {
    const RasterWindow w = window(cost.pitch_mm);
    const double columns = std::floor((w.y_max_mm - w.y_min_mm) / cost.pitch_mm) + 1;
    const double rows = std::floor((w.up_max_mm - w.up_min_mm) / cost.pitch_mm) + 1;
    return columns * rows * cost.ray_s + cost.window_s;
  }
};

Box box_of(std::span<const WindowSpot> spots) {
  Box box;
  for (const WindowSpot& spot : spots) box.add(spot);
  return box;
}

void cut(std::span<WindowSpot> spots, const RasterCost& cost, WindowLayout& layout) {
  const Box whole = box_of(spots);
  double best = whole.time_s(cost);
  size_t best_at = 0;
  bool best_by_y = true;
  for (const bool by_y : {false, true}) {
    const auto before = [by_y](const WindowSpot& s, const WindowSpot& t) {
      return by_y ? std::pair(s.y_mm, s.up_mm) < std::pair(t.y_mm, t.up_mm)
                  : std::pair(s.up_mm, s.y_mm) < std::pair(t.up_mm, t.y_mm);
    };
    std::sort(spots.begin(), spots.end(), before);
    std::vector<double> rest(spots.size() + 1, 0.0);
    Box from_behind;
    for (size_t k = spots.size(); k-- > 0;) {
      from_behind.add(spots[k]);
      rest[k] = from_behind.time_s(cost);
    }
    Box so_far;
    for (size_t k = 1; k < spots.size(); ++k) {
      so_far.add(spots[k - 1]);
      const double both = so_far.time_s(cost) + rest[k];
      if (both >= best) continue;
      best = both;
      best_at = k;
      best_by_y = by_y;
    }
    if (by_y && best_at > 0 && !best_by_y) {
      std::sort(spots.begin(), spots.end(), [](const WindowSpot& s, const WindowSpot& t) {
        return std::pair(s.up_mm, s.y_mm) < std::pair(t.up_mm, t.y_mm);
      });
    }
  }
  if (best_at == 0) {
    layout.windows.push_back(whole.window(cost.pitch_mm));
    layout.time_s += best;
    return;
  }
  cut(spots.first(best_at), cost, layout);
  cut(spots.subspan(best_at), cost, layout);
}

}  // namespace

WindowSpot window_spot(const HeadGeometry& head, int32_t a_urad, int32_t b_urad, double reach_mm) {
  const Vec3 across = head.y.cross(head.up);
  const auto in_plane = [&](const MachineRay& ray) {
    const double way = (head.aim_mm - ray.origin_mm).dot(across) / ray.direction.dot(across);
    return Vec3(ray.origin_mm + way * ray.direction - head.aim_mm);
  };
  return {in_plane(ray_of_mirrors(head, a_urad, 0)).dot(head.y),
          in_plane(ray_of_mirrors(head, 0, b_urad)).dot(head.up), reach_mm};
}

RasterCost raster_cost(const PlanningMachine& machine, double pitch_mm, uint32_t samples) {
  const double distance = (ray_of_mirrors(machine.head, 0, 0).origin_mm - machine.head.aim_mm).norm();
  const auto step = static_cast<int32_t>(1e6 * mirror_step_rad(pitch_mm, distance));
  return {pitch_mm, ray_time_s(machine, samples, step), 1e-6 * machine.config.measure.stage_settle_us};
}

RasterWindow window_around(std::span<const WindowSpot> spots, const RasterCost& cost) {
  return box_of(spots).window(cost.pitch_mm);
}

double time_of_window_s(std::span<const WindowSpot> spots, const RasterCost& cost) {
  return spots.empty() ? 0 : box_of(spots).time_s(cost);
}

WindowLayout lay_windows(std::vector<WindowSpot> spots, const RasterCost& cost) {
  WindowLayout layout;
  if (!spots.empty()) cut(spots, cost, layout);
  return layout;
}

}  // namespace tetragauge
