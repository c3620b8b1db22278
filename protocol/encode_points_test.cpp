// SPDX-License-Identifier: Apache-2.0
// The oracle is nanopb's general encoder, which firmware and host use for every other message.
#include "protocol/encode_points.hpp"

#include <gtest/gtest.h>
#include <pb_encode.h>

#include <random>
#include <vector>

namespace tetragauge {
namespace {

std::vector<uint8_t> by_nanopb(const tg_PointBatch& batch, size_t capacity) {
  tg_MachineMessage message = tg_MachineMessage_init_zero;
  message.which_body = tg_MachineMessage_points_tag;
  message.body.points = batch;
  std::vector<uint8_t> bytes(capacity);
  pb_ostream_t stream = pb_ostream_from_buffer(bytes.data(), bytes.size());
  const bool fits = pb_encode(&stream, tg_MachineMessage_fields, &message);
  bytes.resize(fits ? stream.bytes_written : 0);
  return bytes;
}

std::vector<uint8_t> by_hand(const tg_PointBatch& batch, size_t capacity) {
  std::vector<uint8_t> bytes(capacity + 1, 0xA5);
  const size_t length = encode_points(batch, bytes.data(), capacity);
  EXPECT_EQ(bytes[capacity], 0xA5) << "wrote beyond its room";
  EXPECT_LE(length, capacity);
  bytes.resize(length);
  return bytes;
}

TEST(EncodePoints, EveryBatchIsWhatNanopbMakesOfIt) {
  std::mt19937 random(8);
  const auto any = [&] {
    return static_cast<uint32_t>(random()) >> (random() % 33 == 32 ? 31 : random() % 32);
  };
  const auto any_signed = [&] { return static_cast<int32_t>(any() * (random() % 2 == 0 ? 1u : ~0u)); };
  for (int trial = 0; trial < 3000; ++trial) {
    tg_PointBatch batch = tg_PointBatch_init_zero;
    if (random() % 8 != 0) {
      batch.plan_id = any();
      batch.view = any();
      batch.first_ray = any();
      batch.table_udeg = any_signed();
      batch.slide_um = any_signed();
    }
    const auto fill = [&](int32_t* out, pb_size_t& count, uint32_t most) {
      count = static_cast<pb_size_t>(random() % 3 == 0 ? 0 : random() % (most + 1));
      for (pb_size_t i = 0; i < count; ++i) out[i] = any_signed();
    };
    const auto fill_bytes = [&](uint8_t* out, pb_size_t& count, uint32_t most) {
      count = static_cast<pb_size_t>(random() % 3 == 0 ? 0 : random() % (most + 1));
      for (pb_size_t i = 0; i < count; ++i) out[i] = static_cast<uint8_t>(any());
    };
    fill(batch.a_urad, batch.a_urad_count, 96);
    fill(batch.b_urad, batch.b_urad_count, 96);
    fill(batch.x_um, batch.x_um_count, 48);
    fill(batch.y_um, batch.y_um_count, 48);
    fill(batch.z_um, batch.z_um_count, 48);
    fill(batch.sigma_100nm, batch.sigma_100nm_count, 48);
    fill(batch.intensity_permille, batch.intensity_permille_count, 48);
    fill_bytes(batch.flags, batch.flags_count, 48);
    fill_bytes(batch.rejected_beam, batch.rejected_beam_count, 96);
    fill_bytes(batch.rejected_reason, batch.rejected_reason_count, 96);

    const std::vector<uint8_t> whole = by_nanopb(batch, 8192);
    ASSERT_EQ(by_hand(batch, 8192), whole);
    // It fits where it fits to the byte, and not in one byte less.
    EXPECT_EQ(by_hand(batch, whole.size()), whole);
    EXPECT_TRUE(by_hand(batch, whole.size() - 1).empty());
    EXPECT_TRUE(by_hand(batch, random() % whole.size()).empty());
  }
}

}  // namespace
}  // namespace tetragauge
