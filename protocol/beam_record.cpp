// SPDX-License-Identifier: Apache-2.0
#include "protocol/beam_record.hpp"

#include <bit>

#include "protocol/frame.hpp"

namespace tetragauge {
namespace {

uint32_t zigzag(int32_t value) {
  return (static_cast<uint32_t>(value) << 1) ^ static_cast<uint32_t>(value >> 31);
}

uint32_t varint_bytes(uint32_t value) {
  uint32_t bytes = 1;
  while (value >= 0x80) {
    value >>= 7;
    ++bytes;
  }
  return bytes;
}

// Differences wrap, so that any two values have one; beams_of_batch wraps back.
int32_t difference(uint32_t to, uint32_t from) {
  return static_cast<int32_t>(to - from);
}
int32_t difference(int32_t to, int32_t from) {
  return difference(static_cast<uint32_t>(to), static_cast<uint32_t>(from));
}
int32_t sum(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}

// Envelope (tag and length 3), 10 arrays (tag and length 3 each; fields below 16 have one-byte tags).
constexpr uint32_t kFixedBytes = 3 + 10 * 3;

}  // namespace

uint32_t crc_of_beam(const BeamRecord& beam, uint32_t crc) {
  const uint32_t fields[] = {beam.view,
                             beam.ray,
                             static_cast<uint32_t>(beam.a_urad),
                             static_cast<uint32_t>(beam.b_urad),
                             beam.reason,
                             static_cast<uint32_t>(beam.x_um),
                             static_cast<uint32_t>(beam.y_um),
                             static_cast<uint32_t>(beam.z_um),
                             beam.sigma_100nm,
                             beam.intensity_permille,
                             beam.flags};
  static_assert(std::endian::native == std::endian::little);
  return crc32c(fields, sizeof fields[0] * (beam.reason == 0 ? 11u : 5u), crc);
}

void BatchBuilder::start(uint32_t plan_id, uint32_t view, int32_t table_udeg, int32_t slide_um) {
  batch_.plan_id = plan_id;
  batch_.view = view;
  batch_.first_ray = 0;
  batch_.table_udeg = table_udeg;
  batch_.slide_um = slide_um;
  batch_.a_urad_count = batch_.b_urad_count = 0;
  batch_.x_um_count = batch_.y_um_count = batch_.z_um_count = 0;
  batch_.sigma_100nm_count = batch_.intensity_permille_count = batch_.flags_count = 0;
  batch_.rejected_beam_count = batch_.rejected_reason_count = 0;
  last_beam_ = last_point_ = {};
  last_rejected_ = 0;
  any_flag_ = false;
  bytes_ = kFixedBytes + 3 + varint_bytes(plan_id) + varint_bytes(view) + 2 +
           varint_bytes(zigzag(table_udeg)) + varint_bytes(zigzag(slide_um));
}

bool BatchBuilder::add(const BeamRecord& beam) {
  const uint32_t index = batch_.a_urad_count;
  if (index == kBatchBeams || beam.view != batch_.view) return false;
  if (index > 0 && beam.ray != last_beam_.ray + 1) return false;

  uint32_t more = index == 0 ? varint_bytes(beam.ray) : 0;
  const int32_t da = difference(beam.a_urad, last_beam_.a_urad);
  const int32_t db = difference(beam.b_urad, last_beam_.b_urad);
  more += varint_bytes(zigzag(da)) + varint_bytes(zigzag(db));
  const uint32_t point = batch_.x_um_count;
  const int32_t dx = difference(beam.x_um, last_point_.x_um);
  const int32_t dy = difference(beam.y_um, last_point_.y_um);
  const int32_t dz = difference(beam.z_um, last_point_.z_um);
  const int32_t dsigma = difference(beam.sigma_100nm, last_point_.sigma_100nm);
  const int32_t dintensity = difference(beam.intensity_permille, last_point_.intensity_permille);
  const bool any_flag = any_flag_ || beam.flags != 0;
  if (beam.reason == 0) {
    if (point == kBatchPoints) return false;
    more += varint_bytes(zigzag(dx)) + varint_bytes(zigzag(dy)) + varint_bytes(zigzag(dz)) +
            varint_bytes(zigzag(dsigma)) + varint_bytes(zigzag(dintensity));
    // The first flag brings the array with an entry for every point so far.
    if (any_flag) more += any_flag_ ? 1 : point + 1;
  } else {
    more += 2;
  }
  if (bytes_ + more > kFramePayloadBytes) return false;

  if (index == 0) batch_.first_ray = beam.ray;
  batch_.a_urad[batch_.a_urad_count++] = da;
  batch_.b_urad[batch_.b_urad_count++] = db;
  if (beam.reason == 0) {
    batch_.x_um[batch_.x_um_count++] = dx;
    batch_.y_um[batch_.y_um_count++] = dy;
    batch_.z_um[batch_.z_um_count++] = dz;
    batch_.sigma_100nm[batch_.sigma_100nm_count++] = dsigma;
    batch_.intensity_permille[batch_.intensity_permille_count++] = dintensity;
    batch_.flags[point] = static_cast<uint8_t>(beam.flags);
    any_flag_ = any_flag;
    last_point_ = beam;
  } else {
    batch_.rejected_beam[batch_.rejected_beam_count++] = static_cast<uint8_t>(index - last_rejected_);
    batch_.rejected_reason[batch_.rejected_reason_count++] = static_cast<uint8_t>(beam.reason);
    last_rejected_ = index;
  }
  last_beam_ = beam;
  bytes_ += more;
  return true;
}

const tg_PointBatch& BatchBuilder::batch() {
  batch_.flags_count = any_flag_ ? batch_.x_um_count : pb_size_t{0};
  return batch_;
}

uint32_t beams_of_batch(const tg_PointBatch& batch, BeamRecord* beams) {
  const uint32_t count = batch.a_urad_count;
  const uint32_t points = batch.x_um_count;
  const bool same_lengths =
      batch.b_urad_count == count && batch.y_um_count == points && batch.z_um_count == points &&
      batch.sigma_100nm_count == points && batch.intensity_permille_count == points &&
      (batch.flags_count == points || batch.flags_count == 0) &&
      batch.rejected_reason_count == batch.rejected_beam_count && points + batch.rejected_beam_count == count;
  if (!same_lengths || count > kBatchBeams) return 0;

  BeamRecord beam, point;
  uint32_t next_point = 0, next_rejected = 0, rejected_at = 0;
  for (uint32_t i = 0; i < count; ++i) {
    beam.a_urad = sum(beam.a_urad, batch.a_urad[i]);
    beam.b_urad = sum(beam.b_urad, batch.b_urad[i]);
    const bool rejected =
        next_rejected < batch.rejected_beam_count && rejected_at + batch.rejected_beam[next_rejected] == i;
    BeamRecord& out = beams[i];
    if (rejected) {
      rejected_at = i;
      out = {};
      out.reason = batch.rejected_reason[next_rejected++];
      if (out.reason == 0) return 0;
    } else {
      if (next_point == points) return 0;
      point.x_um = sum(point.x_um, batch.x_um[next_point]);
      point.y_um = sum(point.y_um, batch.y_um[next_point]);
      point.z_um = sum(point.z_um, batch.z_um[next_point]);
      point.sigma_100nm += static_cast<uint32_t>(batch.sigma_100nm[next_point]);
      point.intensity_permille += static_cast<uint32_t>(batch.intensity_permille[next_point]);
      out = point;
      out.flags = batch.flags_count > 0 ? batch.flags[next_point] : 0u;
      ++next_point;
    }
    out.view = batch.view;
    out.ray = batch.first_ray + i;
    out.a_urad = beam.a_urad;
    out.b_urad = beam.b_urad;
  }
  return count;
}

}  // namespace tetragauge
