// SPDX-License-Identifier: GPL-3.0-or-later
// Beams as the machine reports them (machine frame, mirror angles) put into a scan in the part frame.
#pragma once

#include <span>

#include "host/session/head_geometry.hpp"
#include "host/session/run_scan.hpp"
#include "protocol/beam_record.hpp"

namespace tetragauge {

class ScanBuilder {
 public:
  ScanBuilder(HeadGeometry head, const tg_HelloReply& machine, const ScanOptions& options);

  // Beams measured with table and slide as `batch` says. Their view is the whole plan's.
  void take(const tg_PointBatch& batch, std::span<const BeamRecord> beams);

  MeasuredScan measured;

 private:
  void add_point(const BeamRecord& beam, const Vec3& point, const Vec3& origin, const Vec3& direction);

  HeadGeometry head_;
  bool keep_table_;
};

}  // namespace tetragauge
