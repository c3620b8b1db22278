// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/run_scan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/session/head_geometry.hpp"
#include "host/session/prepare_machine.hpp"
#include "host/session/receive_beams.hpp"

namespace tetragauge {
namespace {

// A point is on the table's top when it lies no higher than its own noise allows, and never when it is
// clearly above.
constexpr double kTableSigmas = 5;
constexpr double kTableHeight_mm = 0.15;

// Standard uncertainty of the machine's geometry. An emulated machine is built as it is configured: what is
// left (mirror codes of 12 urad of beam, coordinates in whole micrometres, the finite spot) is smaller than
// this. A real one carries no calibration record in this protocol version, and gets the +-0.1 mm (95 %) of
// the thesis's machine.
constexpr double kEmulatedGeometry_mm = 0.005, kUncalibratedGeometry_mm = 0.05;

std::string hex(uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(value));
  return text;
}

// The same plan has the same id, in every run.
uint32_t plan_id_of(const std::vector<tg_View>& views) {
  uint32_t crc = 0;
  for (const tg_View& v : views) {
    const int64_t fields[] = {v.table_udeg,  v.slide_um, v.a_first_urad, v.b_first_urad, v.a_step_urad,
                              v.b_step_urad, v.columns,  v.rows,         v.samples};
    crc = crc32c(fields, sizeof fields, crc);
  }
  return std::max(crc, 1u);
}

Status load_plan(Link& link, uint32_t plan_id, const std::vector<tg_View>& views) {
  if (views.size() > link.machine().max_views) {
    return bad_input("the plan has " + std::to_string(views.size()) + " views, the machine takes " +
                     std::to_string(link.machine().max_views) + "; split it");
  }
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_scan_load_tag;
  tg_ScanLoad& load = message.body.scan_load;
  constexpr size_t kChunk = std::extent_v<decltype(load.views)>;
  for (size_t first = 0; first < views.size(); first += kChunk) {
    const size_t count = std::min(kChunk, views.size() - first);
    load.plan_id = plan_id;
    load.first_view = static_cast<uint32_t>(first);
    load.total_views = static_cast<uint32_t>(views.size());
    load.views_count = static_cast<pb_size_t>(count);
    std::copy_n(views.begin() + static_cast<std::ptrdiff_t>(first), count, load.views);
    const auto reply = link.request(message);
    if (!reply) return reply.error();
  }
  return Done{};
}

Status start_scan(Link& link, uint32_t plan_id) {
  if (const Status done = grant_first_credit(link, plan_id); !done) return done;
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_scan_start_tag;
  message.body.scan_start.plan_id = plan_id;
  const auto reply = link.request(message);
  if (!reply) return reply.error();
  return Done{};
}

// Puts beams into the scan, in the part frame.
class ScanBuilder {
 public:
  ScanBuilder(const HeadGeometry& head, bool keep_table) : head_(head), keep_table_(keep_table) {}

  void take(const tg_PointBatch& batch, std::span<const BeamRecord> beams) {
    const RigidTransform T_part_machine =
        T_machine_part(head_, batch.table_udeg * 1e-6, batch.slide_um * 1e-3).inverse();
    for (const BeamRecord& beam : beams) {
      const MachineRay ray = ray_of_mirrors(head_, beam.a_urad, beam.b_urad);
      const Vec3 origin = T_part_machine * ray.origin_mm, direction = T_part_machine.R * ray.direction;
      ++measured.counts.beams;
      if (beam.reason == 0) {
        add_point(beam, T_part_machine * (1e-3 * Vec3(beam.x_um, beam.y_um, beam.z_um)), origin, direction);
      } else {
        measured.scan.rejected.push_back({origin, direction, beam.reason, beam.view});
        ++measured.counts.rejected[std::min<size_t>(beam.reason, measured.counts.rejected.size() - 1)];
      }
    }
  }

  MeasuredScan measured;

 private:
  void add_point(const BeamRecord& beam, const Vec3& point, const Vec3& origin, const Vec3& direction) {
    const double sigma = 1e-4 * beam.sigma_100nm;
    ScanCounts& counts = measured.counts;
    if (!keep_table_ &&
        point.z() < std::max(kTableHeight_mm, kTableSigmas * sigma * std::abs(direction.z()))) {
      ++counts.table_points;
      return;
    }
    Scan& scan = measured.scan;
    scan.points.push_back(point);
    scan.ray_origins.push_back(origin);
    scan.sigma_mm.push_back(static_cast<float>(sigma));
    scan.intensity.push_back(static_cast<float>(1e-3 * beam.intensity_permille));
    scan.view.push_back(beam.view);
    scan.flags.push_back(beam.flags);
    ++counts.points;
    if ((beam.flags & kPointUnsettled) != 0) ++counts.unsettled;
    if ((beam.flags & kPointOneCamera) != 0) ++counts.one_camera;
  }

  const HeadGeometry& head_;
  bool keep_table_;
};

ScanHeader header_of(const tg_HelloReply& machine, const ScanOptions& options) {
  ScanHeader header;
  header.machine_id = std::string(machine.board) + "/" + machine.firmware_version;
  header.calibration_id = hex(machine.config_crc);
  const bool emulated = (machine.capabilities & tg_Capability_CAPABILITY_EMULATED) != 0;
  header.u_cal_mm = emulated ? kEmulatedGeometry_mm : kUncalibratedGeometry_mm;
  header.seed = options.seed;
  return header;
}

}  // namespace

Result<MeasuredScan> run_scan(Link& link, const ScanPlan& plan, const ScanOptions& options) {
  if (const Status done = prepare_machine(link, options); !done) return done.error();
  const auto head = read_head_geometry(link);
  if (!head) return head.error();

  std::vector<tg_View> views;
  size_t beams_planned = 0;
  for (const PlannedView& planned : plan.views) {
    const auto view = lay_raster(*head, planned);
    if (!view) return view.error();
    beams_planned += size_t{view->columns} * view->rows;
    views.push_back(*view);
  }
  const uint32_t plan_id = plan_id_of(views);
  if (const Status done = load_plan(link, plan_id, views); !done) return done.error();
  const auto before = link.status();
  if (!before) return before.error();

  ScanBuilder builder(*head, options.keep_table);
  builder.measured.scan.header = header_of(link.machine(), options);
  const auto take = [&](const tg_PointBatch& batch, std::span<const BeamRecord> beams) {
    builder.take(batch, beams);
    if (!options.on_progress) return;
    const ScanCounts& counts = builder.measured.counts;
    options.on_progress({.view = size_t{batch.view} + 1,
                         .views = views.size(),
                         .points = counts.points,
                         .rejected = builder.measured.scan.rejected.size(),
                         .beams = counts.beams,
                         .beams_planned = beams_planned});
  };
  if (const Status done = start_scan(link, plan_id); !done) return done.error();
  const auto end = receive_beams(link, plan_id, options, take);
  if (!end) {
    // The laser must not stay on; a machine that can be reached is told, one that cannot pauses by itself.
    // The first error is the one that counts.
    if (link.silent_for() < link.silence()) (void)command(link, tg_HostMessage_scan_abort_tag);
    return end.error();
  }
  builder.measured.counts.machine_time_s = 1e-6 * static_cast<double>(end->clock_us - before->clock_us);
  return std::move(builder.measured);
}

}  // namespace tetragauge
