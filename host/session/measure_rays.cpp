// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/measure_rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "host/session/load_plan.hpp"
#include "host/session/measure_plan.hpp"
#include "host/session/prepare_machine.hpp"

namespace tetragauge {
namespace {

// Mirror angles of one direction.
struct Aim {
  int32_t a_urad = 0, b_urad = 0;
};

// All directions of one place of the stage, or those of them that one run measures.
struct ListedView {
  int32_t table_udeg = 0, slide_um = 0;
  uint32_t number = 0;  // in the scan
  std::vector<Aim> aims;
};

using Run = std::vector<ListedView>;

// No machine turns or slides further; what this one can do it says itself.
constexpr double kFurthestTable_deg = 2000, kFurthestSlide_mm = 2000;

Status check_ray(const Link& link, const SingleRay& ray, size_t index, int32_t limit_urad) {
  const std::string name = link.device() + ": direction " + std::to_string(index + 1) + " of the list: ";
  for (const auto& [mirror, urad] : {std::pair("a", ray.a_urad), std::pair("b", ray.b_urad)}) {
    if (urad >= -limit_urad && urad <= limit_urad) continue;
    return bad_input(name + "mirror " + mirror + " would have to stand at " + std::to_string(urad) +
                     " urad, and reaches -" + std::to_string(limit_urad) + " to " +
                     std::to_string(limit_urad) + "; leave it out, or turn the table");
  }
  if (!(std::abs(ray.table_deg) <= kFurthestTable_deg) || !(std::abs(ray.slide_mm) <= kFurthestSlide_mm)) {
    return bad_input(name + "table_deg and slide_mm must be numbers within the stage's travel");
  }
  return Done{};
}

std::vector<ListedView> group_by_place(std::span<const SingleRay> rays) {
  std::vector<ListedView> views;
  std::map<std::pair<int32_t, int32_t>, size_t> view_at;
  for (const SingleRay& ray : rays) {
    const auto table_udeg = static_cast<int32_t>(std::lround(ray.table_deg * 1e6));
    const auto slide_um = static_cast<int32_t>(std::lround(ray.slide_mm * 1e3));
    const auto [at, is_new] = view_at.try_emplace({table_udeg, slide_um}, views.size());
    if (is_new) views.push_back({table_udeg, slide_um, static_cast<uint32_t>(views.size()), {}});
    views[at->second].aims.push_back({ray.a_urad, ray.b_urad});
  }
  return views;
}

// As much in each run as the machine holds.
std::vector<Run> split_into_runs(std::span<const ListedView> views, const tg_HelloReply& machine) {
  std::vector<Run> runs;
  size_t room = 0;
  for (const ListedView& view : views) {
    for (size_t first = 0; first < view.aims.size();) {
      if (room == 0 || runs.back().size() == machine.max_views) {
        runs.emplace_back();
        room = machine.max_listed_rays;
      }
      const size_t count = std::min(room, view.aims.size() - first);
      const auto begin = view.aims.begin() + static_cast<std::ptrdiff_t>(first);
      runs.back().push_back(
          {view.table_udeg, view.slide_um, view.number, {begin, begin + static_cast<std::ptrdiff_t>(count)}});
      first += count;
      room -= count;
    }
  }
  return runs;
}

// The same run of the same list has the same id.
uint32_t plan_id_of(const Run& run, size_t number, uint32_t samples) {
  const int64_t head[] = {static_cast<int64_t>(number), samples};
  uint32_t crc = crc32c(head, sizeof head, 0);
  for (const ListedView& view : run) {
    const int64_t place[] = {view.table_udeg, view.slide_um, static_cast<int64_t>(view.aims.size())};
    crc = crc32c(place, sizeof place, crc);
    crc = crc32c(view.aims.data(), view.aims.size() * sizeof(Aim), crc);
  }
  return std::max(crc, 1u);
}

// The difference as the machine undoes it.
int32_t difference(int32_t to, int32_t from) {
  return static_cast<int32_t>(static_cast<uint32_t>(to) - static_cast<uint32_t>(from));
}

std::vector<tg_HostMessage> load_chunks(const Run& run, uint32_t plan_id, uint32_t samples) {
  constexpr size_t kChunk = std::extent_v<decltype(tg_MeasureRays::a_urad)>;
  std::vector<tg_HostMessage> chunks;
  for (size_t v = 0; v < run.size(); ++v) {
    const ListedView& view = run[v];
    for (size_t first = 0; first < view.aims.size(); first += kChunk) {
      tg_HostMessage message = tg_HostMessage_init_zero;
      message.which_body = tg_HostMessage_measure_rays_tag;
      tg_MeasureRays& chunk = message.body.measure_rays;
      chunk.plan_id = plan_id;
      chunk.view = static_cast<uint32_t>(v);
      chunk.total_views = static_cast<uint32_t>(run.size());
      chunk.table_udeg = view.table_udeg;
      chunk.slide_um = view.slide_um;
      chunk.samples = samples;
      chunk.first_ray = static_cast<uint32_t>(first);
      chunk.total_rays = static_cast<uint32_t>(view.aims.size());
      Aim last;
      for (size_t i = first; i < std::min(first + kChunk, view.aims.size()); ++i) {
        chunk.a_urad[chunk.a_urad_count++] = difference(view.aims[i].a_urad, last.a_urad);
        chunk.b_urad[chunk.b_urad_count++] = difference(view.aims[i].b_urad, last.b_urad);
        last = view.aims[i];
      }
      chunks.push_back(message);
    }
  }
  return chunks;
}

// Beams of a run under the views of the whole scan, in order.
class RunTaker {
 public:
  RunTaker(const Run& run, ScanBuilder& builder) : run_(run), builder_(builder) {}

  void take(const tg_PointBatch& batch, std::span<const BeamRecord> beams) {
    std::array<BeamRecord, kBatchBeams> renamed;
    size_t count = 0;
    for (const BeamRecord& beam : beams) {
      if (done() || beam.view != view_ || beam.ray != ray_) continue;
      renamed[count] = beam;
      renamed[count].view = run_[view_].number;
      ++count;
      if (++ray_ == run_[view_].aims.size()) {
        ++view_;
        ray_ = 0;
      }
    }
    builder_.take(batch, {renamed.data(), count});
  }
  bool done() const { return view_ == run_.size(); }

 private:
  const Run& run_;
  ScanBuilder& builder_;
  size_t view_ = 0, ray_ = 0;  // the next one
};

}  // namespace

Result<MeasuredScan> measure_rays(Link& link, std::span<const SingleRay> rays, uint32_t samples,
                                  const ScanOptions& options) {
  if (options.journal) return internal_error("measure_rays keeps no journal");
  const auto config = read_head_config(link);
  if (!config) return config.error();
  const HeadGeometry head = head_geometry(config->galvo, config->stage);
  for (size_t i = 0; i < rays.size(); ++i) {
    if (const Status good = check_ray(link, rays[i], i, head.mirror_limit_urad); !good) return good.error();
  }
  if (link.machine().max_listed_rays == 0 || link.machine().max_views == 0) {
    return machine_error(link.device() +
                         ": the machine takes no single directions; flash firmware of this version");
  }
  const std::vector<ListedView> views = group_by_place(rays);
  const std::vector<Run> runs = split_into_runs(views, link.machine());

  ScanBuilder builder(head, link.machine(), options);
  ScanCounts& counts = builder.measured.counts;
  for (size_t number = 0; number < runs.size(); ++number) {
    const Run& run = runs[number];
    const uint32_t plan_id = plan_id_of(run, number, samples);
    if (const Status done = prepare_machine(link, options); !done) return done.error();
    if (const Status done = send_chunks(link, load_chunks(run, plan_id, samples)); !done) return done.error();
    if (const Status done = start_scan(link, plan_id); !done) return done.error();
    RunTaker taker(run, builder);
    StreamTakers takers;
    takers.take = [&](const tg_PointBatch& batch, std::span<const BeamRecord> beams) {
      taker.take(batch, beams);
      if (!options.on_progress) return;
      options.on_progress({.view = run[std::min<size_t>(batch.view, run.size() - 1)].number + 1,
                           .views = views.size(),
                           .beams_planned = rays.size(),
                           .counts = counts});
    };
    const auto time_s = take_stream(link, plan_id, {}, options, takers);
    if (!time_s) return time_s.error();
    if (!taker.done()) return incomplete_scan(link);
    counts.machine_time_s += *time_s;
    counts.timed_beams = counts.beams;
  }
  return std::move(builder.measured);
}

}  // namespace tetragauge
