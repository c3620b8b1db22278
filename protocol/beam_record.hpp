// SPDX-License-Identifier: Apache-2.0
// What became of one beam, and the checksum of a whole scan.
//
// The scan's CRC-32C runs over one record per beam in measured order, fields little-endian, 4 bytes each:
//   point:    view, ray, a_urad, b_urad, 0, x_um, y_um, z_um, sigma_100nm, intensity_permille, flags
//   rejected: view, ray, a_urad, b_urad, reason
// so it depends on what was measured, not on how it was cut into batches.
#pragma once

#include <cstdint>

#include "protocol/machine.pb.h"

namespace tetragauge {

struct BeamRecord {
  uint32_t view = 0;
  uint32_t ray = 0;  // within the view
  int32_t a_urad = 0, b_urad = 0;
  uint32_t reason = 0;  // tg_RejectReason; 0: a point, and the rest is valid
  int32_t x_um = 0, y_um = 0, z_um = 0;
  uint32_t sigma_100nm = 0;
  uint32_t intensity_permille = 0;
  uint32_t flags = 0;

  bool operator==(const BeamRecord&) const = default;
};

inline constexpr uint32_t kBatchBeams = 96;   // most beams in a batch
inline constexpr uint32_t kBatchPoints = 48;  // most points in a batch

uint32_t crc_of_beam(const BeamRecord& beam, uint32_t crc);

// Collects beams of one view into a batch that fits one frame.
class BatchBuilder {
 public:
  void start(uint32_t plan_id, uint32_t view, int32_t table_udeg, int32_t slide_um);
  // False when the beam does not fit any more, or does not follow the last one: send the batch, start the
  // next.
  bool add(const BeamRecord& beam);
  bool empty() const { return batch_.a_urad_count == 0; }
  uint32_t view() const { return batch_.view; }
  const tg_PointBatch& batch();

 private:
  tg_PointBatch batch_ = tg_PointBatch_init_zero;
  BeamRecord last_beam_, last_point_;
  uint32_t last_rejected_ = 0;
  uint32_t bytes_ = 0;
  bool any_flag_ = false;
};

// Beams of a batch in order, into `beams` (kBatchBeams). Returns their number, 0 when the arrays contradict
// each other.
uint32_t beams_of_batch(const tg_PointBatch& batch, BeamRecord* beams);

}  // namespace tetragauge
