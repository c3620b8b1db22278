// SPDX-License-Identifier: Apache-2.0
// Protocol buffers, encoding of proto3 (protobuf.dev/programming-guides/encoding): fields in order of their
// numbers, those that are zero or empty left out; sint32 zigzag; arrays packed.
#include "protocol/encode_points.hpp"

namespace tetragauge {
namespace {

constexpr uint8_t kVarint = 0, kBytes = 2;  // wire types

uint32_t zigzag(int32_t value) {
  return (static_cast<uint32_t>(value) << 1) ^ static_cast<uint32_t>(value >> 31);
}

class Writer {
 public:
  Writer(uint8_t* out, size_t capacity) : begin_(out), at_(out), end_(out + capacity) {}

  void scalar(uint32_t field, uint32_t value) {
    if (value == 0) return;
    tag(field, kVarint);
    varint(value);
  }

  template <class Element>
  void array(uint32_t field, const Element* elements, uint32_t count) {
    if (count == 0) return;
    const uint32_t start = open(field);
    for (uint32_t i = 0; i < count; ++i) varint(bits(elements[i]));
    close(start);
  }

  // A field of bytes: its length stands before it and is known after it. Nearly always it takes one byte.
  uint32_t open(uint32_t field) {
    tag(field, kBytes);
    put(0);
    return static_cast<uint32_t>(at_ - begin_);
  }
  void close(uint32_t start) {
    if (!fits_) return;
    const auto length = static_cast<uint32_t>(at_ - begin_) - start;
    uint32_t more = 0;
    for (uint32_t rest = length >> 7; rest > 0; rest >>= 7) ++more;
    if (static_cast<uint32_t>(end_ - at_) < more) {
      fits_ = false;
      return;
    }
    // By hand: the images have no memmove.
    for (uint32_t i = more > 0 ? length : 0; i-- > 0;) begin_[start + more + i] = begin_[start + i];
    uint8_t* const end = at_ + more;
    at_ = begin_ + start - 1;
    varint(length);
    at_ = end;
  }

  size_t bytes() const { return fits_ ? static_cast<size_t>(at_ - begin_) : 0; }

 private:
  static uint32_t bits(int32_t value) { return zigzag(value); }
  static uint32_t bits(uint8_t value) { return value; }

  void put(uint32_t byte) {
    if (at_ == end_) {
      fits_ = false;
      return;
    }
    *at_++ = static_cast<uint8_t>(byte);
  }
  void varint(uint32_t value) {
    for (; value >= 0x80; value >>= 7) put(value | 0x80);
    put(value);
  }
  // Field numbers below 16 only: one byte.
  void tag(uint32_t field, uint8_t type) { put(field << 3 | type); }

  uint8_t* const begin_;
  uint8_t* at_;
  uint8_t* const end_;
  bool fits_ = true;
};

}  // namespace

size_t encode_points(const tg_PointBatch& batch, uint8_t* payload, size_t capacity) {
  Writer out(payload, capacity);
  const uint32_t start = out.open(tg_MachineMessage_points_tag);
  out.scalar(tg_PointBatch_plan_id_tag, batch.plan_id);
  out.scalar(tg_PointBatch_view_tag, batch.view);
  out.scalar(tg_PointBatch_first_ray_tag, batch.first_ray);
  out.scalar(tg_PointBatch_table_udeg_tag, zigzag(batch.table_udeg));
  out.scalar(tg_PointBatch_slide_um_tag, zigzag(batch.slide_um));
  out.array(tg_PointBatch_a_urad_tag, batch.a_urad, batch.a_urad_count);
  out.array(tg_PointBatch_b_urad_tag, batch.b_urad, batch.b_urad_count);
  out.array(tg_PointBatch_x_um_tag, batch.x_um, batch.x_um_count);
  out.array(tg_PointBatch_y_um_tag, batch.y_um, batch.y_um_count);
  out.array(tg_PointBatch_z_um_tag, batch.z_um, batch.z_um_count);
  out.array(tg_PointBatch_sigma_100nm_tag, batch.sigma_100nm, batch.sigma_100nm_count);
  out.array(tg_PointBatch_intensity_permille_tag, batch.intensity_permille, batch.intensity_permille_count);
  out.array(tg_PointBatch_flags_tag, batch.flags, batch.flags_count);
  out.array(tg_PointBatch_rejected_beam_tag, batch.rejected_beam, batch.rejected_beam_count);
  out.array(tg_PointBatch_rejected_reason_tag, batch.rejected_reason, batch.rejected_reason_count);
  out.close(start);
  return out.bytes();
}

}  // namespace tetragauge
