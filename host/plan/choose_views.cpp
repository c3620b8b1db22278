// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/choose_views.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace tetragauge {
namespace {

// What one camera alone sees is a little less certain. A corner's spot widens windows and weighs nothing.
constexpr double kOneCameraWeight = 0.6;
// So small a share of what can be seen of a face is not worth a view of its own.
constexpr double kNegligibleShare = 0.02;
// So many candidates, the best by one window each, are compared with their windows cut.
constexpr size_t kLookedAtCloser = 8;
constexpr int kMostPasses = 4;

// How much of each face is still to be covered.
class FaceShares {
 public:
  FaceShares(std::span<const Patch> patches, const std::vector<bool>& wanted) {
    for (size_t k = 0; k < patches.size(); ++k) {
      const auto face = static_cast<size_t>(patches[k].face);
      if (face >= whole_mm2_.size()) whole_mm2_.resize(face + 1, 0.0);
      if (wanted[k]) whole_mm2_[face] += patches[k].area_mm2;
    }
    open_mm2_ = whole_mm2_;
  }
  void take(const Patch& patch) { open_mm2_[static_cast<size_t>(patch.face)] -= patch.area_mm2; }
  bool is_done(int face) const {
    const auto f = static_cast<size_t>(face);
    return open_mm2_[f] <= kNegligibleShare * whole_mm2_[f];
  }

 private:
  std::vector<double> whole_mm2_, open_mm2_;
};

class Chooser {
 public:
  Chooser(const SightSurvey& survey, std::span<const Patch> patches, const ViewCost& cost)
      : survey_(survey), patches_(patches), cost_(cost) {}

  double time_s(const ChosenView& view) const {
    return cost_.place_s + lay_windows(spots(view), cost_.raster).time_s;
  }

  std::optional<ChosenView> best_next(const std::vector<bool>& open) const {
    struct Rated {
      double rate;
      size_t candidate;
    };
    std::vector<Rated> rated;
    for (size_t c = 0; c < survey_.candidates.size(); ++c) {
      const ChosenView view = all_open(c, open);
      const double gain = weight(view);
      if (!(gain > 0)) continue;
      rated.push_back({gain / (cost_.place_s + time_of_window_s(spots(view), cost_.raster)), c});
    }
    if (rated.empty()) return std::nullopt;
    std::stable_sort(rated.begin(), rated.end(),
                     [](const Rated& a, const Rated& b) { return a.rate > b.rate; });
    std::optional<ChosenView> best;
    double best_rate = -1;
    for (size_t k = 0; k < std::min(kLookedAtCloser, rated.size()); ++k) {
      ChosenView view = all_open(rated[k].candidate, open);
      const double rate = weight(view) / time_s(view);
      if (rate <= best_rate) continue;
      best_rate = rate;
      best = std::move(view);
    }
    return best;
  }

  // Gives what `from` measures to the others; nothing when one of its patches only it can see, or when that
  // takes longer.
  bool drop(std::vector<ChosenView>& views, size_t from) const {
    std::vector<ChosenView> others;
    for (size_t k = 0; k < views.size(); ++k)
      if (k != from) others.push_back(views[k]);
    std::vector<std::map<uint32_t, uint32_t>> sight_of;  // by patch
    for (const ChosenView& view : others) {
      std::map<uint32_t, uint32_t>& map = sight_of.emplace_back();
      const std::vector<PatchSight>& sights = survey_.candidates[view.candidate].sights;
      for (uint32_t s = 0; s < sights.size(); ++s) map[sights[s].patch] = s;
    }
    double before = time_s(views[from]);
    for (const ChosenView& view : others) before += time_s(view);
    for (const uint32_t s : views[from].sights) {
      const uint32_t patch = survey_.candidates[views[from].candidate].sights[s].patch;
      // To the one that sees it most squarely.
      float best = -1;
      size_t taker = 0;
      for (size_t k = 0; k < others.size(); ++k) {
        const auto at = sight_of[k].find(patch);
        if (at == sight_of[k].end()) continue;
        const float cosine = survey_.candidates[others[k].candidate].sights[at->second].cosine;
        if (cosine <= best) continue;
        best = cosine;
        taker = k;
      }
      if (best < 0) return false;
      others[taker].sights.push_back(sight_of[taker][patch]);
    }
    double after = 0;
    for (ChosenView& view : others) {
      std::sort(view.sights.begin(), view.sights.end());
      after += time_s(view);
    }
    if (after >= before) return false;
    views = std::move(others);
    return true;
  }

  // The neighbouring place that measures the same patches in the least time.
  bool move(ChosenView& view) const {
    const CandidateView& here = survey_.candidates[view.candidate];
    std::vector<uint32_t> wanted;
    for (const uint32_t s : view.sights) wanted.push_back(here.sights[s].patch);
    std::sort(wanted.begin(), wanted.end());
    double best = time_s(view);
    std::optional<ChosenView> moved;
    for (size_t c = 0; c < survey_.candidates.size(); ++c) {
      const CandidateView& there = survey_.candidates[c];
      const double turn = std::abs(std::remainder(there.place.table_deg - here.place.table_deg, 360.0));
      if (c == view.candidate || turn > kNear_deg ||
          std::abs(there.place.slide_mm - here.place.slide_mm) > kNear_mm)
        continue;
      ChosenView other{c, {}};
      for (uint32_t s = 0; s < there.sights.size(); ++s)
        if (std::binary_search(wanted.begin(), wanted.end(), there.sights[s].patch))
          other.sights.push_back(s);
      if (other.sights.size() < wanted.size()) continue;
      const double time = time_s(other);
      if (time >= best) continue;
      best = time;
      moved = std::move(other);
    }
    if (!moved) return false;
    view = std::move(*moved);
    return true;
  }

 private:
  static constexpr double kNear_deg = 21, kNear_mm = 51;  // two steps of the survey

  ChosenView all_open(size_t candidate, const std::vector<bool>& open) const {
    ChosenView view{candidate, {}};
    const std::vector<PatchSight>& sights = survey_.candidates[candidate].sights;
    for (uint32_t s = 0; s < sights.size(); ++s)
      if (open[sights[s].patch]) view.sights.push_back(s);
    return view;
  }
  std::vector<WindowSpot> spots(const ChosenView& view) const {
    return window_spots(survey_.candidates[view.candidate], view.sights, patches_);
  }
  double weight(const ChosenView& view) const {
    double sum = 0;
    for (const uint32_t s : view.sights) {
      const PatchSight& sight = survey_.candidates[view.candidate].sights[s];
      if (patches_[sight.patch].area_mm2 > 0) sum += sight.cameras > 1 ? 1 : kOneCameraWeight;
    }
    return sum;
  }

  const SightSurvey& survey_;
  std::span<const Patch> patches_;
  const ViewCost& cost_;
};

}  // namespace

ViewCost view_cost(const PlanningMachine& machine, double pitch_mm, uint32_t samples) {
  const tg_StageConfig& stage = machine.config.stage;
  // A quarter of a turn.
  const double place_s = move_time_s(stage.table, 0, stage.table_steps_per_turn / 4);
  return {raster_cost(machine, pitch_mm, samples), place_s};
}

std::vector<WindowSpot> window_spots(const CandidateView& view, std::span<const uint32_t> sights,
                                     std::span<const Patch> patches) {
  std::vector<WindowSpot> spots;
  for (const uint32_t s : sights) {
    const PatchSight& sight = view.sights[s];
    spots.push_back(
        {static_cast<double>(sight.y_mm), static_cast<double>(sight.up_mm), patches[sight.patch].reach_mm});
  }
  return spots;
}

std::vector<ChosenView> choose_views(const SightSurvey& survey, std::span<const Patch> patches,
                                     const std::vector<bool>& wanted, const ViewCost& cost) {
  const Chooser chooser(survey, patches, cost);
  std::vector<bool> open = wanted;
  FaceShares shares(patches, wanted);
  std::vector<ChosenView> views;
  while (std::optional<ChosenView> next = chooser.best_next(open)) {
    for (const uint32_t s : next->sights) {
      const uint32_t patch = survey.candidates[next->candidate].sights[s].patch;
      open[patch] = false;
      shares.take(patches[patch]);
    }
    for (size_t k = 0; k < patches.size(); ++k) open[k] = open[k] && !shares.is_done(patches[k].face);
    views.push_back(std::move(*next));
  }
  for (int pass = 0; pass < kMostPasses; ++pass) {
    bool changed = false;
    // The last ones chosen had the least left to do.
    for (size_t k = views.size(); k-- > 0;) changed = chooser.drop(views, k) || changed;
    for (ChosenView& view : views) changed = chooser.move(view) || changed;
    if (!changed) break;
  }
  return views;
}

}  // namespace tetragauge
