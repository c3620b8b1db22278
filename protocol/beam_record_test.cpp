// SPDX-License-Identifier: Apache-2.0
#include "protocol/beam_record.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "protocol/message.hpp"

namespace tetragauge {
namespace {

// Cuts beams into batches as the machine does, sends each through a frame, and takes them apart again.
struct Delivery {
  std::vector<BeamRecord> beams;
  size_t wire_bytes = 0;
  size_t batches = 0;
};

void send(BatchBuilder& builder, Delivery* delivery) {
  tg_MachineMessage message = tg_MachineMessage_init_zero;
  message.which_body = tg_MachineMessage_points_tag;
  message.body.points = builder.batch();
  uint8_t wire[kFrameWireBytes];
  const size_t bytes = encode_message({Channel::kStream, 0xFFFFFF00u}, message, wire);
  ASSERT_GT(bytes, 0u) << "the builder promised that it fits";
  delivery->wire_bytes += bytes;
  ++delivery->batches;
  FrameReader reader;
  for (size_t i = 0; i < bytes; ++i) {
    if (!reader.push(wire[i])) continue;
    tg_MachineMessage back = tg_MachineMessage_init_zero;
    ASSERT_TRUE(decode_message(reader.frame(), &back));
    BeamRecord records[kBatchBeams];
    const uint32_t count = beams_of_batch(back.body.points, records);
    ASSERT_GT(count, 0u);
    delivery->beams.insert(delivery->beams.end(), records, records + count);
  }
}

Delivery deliver(const std::vector<BeamRecord>& beams) {
  Delivery delivery;
  BatchBuilder builder;
  const auto start = [&](uint32_t view) { builder.start(0xFFFFFFFFu, view, -179'990'000, 299'995); };
  start(beams.front().view);
  for (const BeamRecord& beam : beams) {
    if (builder.add(beam)) continue;
    send(builder, &delivery);
    start(beam.view);
    EXPECT_TRUE(builder.add(beam)) << "an empty batch takes any beam";
  }
  send(builder, &delivery);
  return delivery;
}

TEST(BeamRecord, AnyBeamsComeBackAsTheyWere) {
  std::mt19937 engine(4);
  const auto random = [&engine] { return static_cast<uint32_t>(engine()); };
  const auto any = [&random] {
    return static_cast<int32_t>(random() >> (random() % 32)) * (random() % 2 ? 1 : -1);
  };
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<BeamRecord> beams;
    uint32_t view = random() % 3, ray = random() % 1000;
    const uint32_t reject_one_in = 1 + random() % 6, flag_one_in = 1 + random() % 100;
    for (int i = 0; i < 300; ++i) {
      BeamRecord beam;
      beam.view = view;
      beam.ray = ray++;
      beam.a_urad = any();
      beam.b_urad = any();
      if (random() % reject_one_in == 0) {
        beam.reason = 1 + random() % 5;
      } else {
        beam.x_um = any();
        beam.y_um = any();
        beam.z_um = any();
        beam.sigma_100nm = random() >> (random() % 32);
        beam.intensity_permille = random() >> (random() % 32);
        beam.flags = random() % flag_one_in == 0 ? 1 + random() % 7 : 0;
      }
      beams.push_back(beam);
      if (random() % 50 == 0) {
        ++view;
        ray = 0;
      }
      if (random() % 50 == 0) ray += 5;  // a gap: a batch holds consecutive rays only
    }
    const Delivery delivery = deliver(beams);
    ASSERT_EQ(delivery.beams, beams);
    uint32_t sent = 0, got = 0;
    for (const BeamRecord& beam : beams) sent = crc_of_beam(beam, sent);
    for (const BeamRecord& beam : delivery.beams) got = crc_of_beam(beam, got);
    EXPECT_EQ(sent, got);
  }
}

TEST(BeamRecord, CrcIsOfTheDocumentedBytes) {
  BeamRecord point;
  point.view = 1, point.ray = 2, point.a_urad = -3, point.b_urad = 4;
  point.x_um = 5, point.y_um = -6, point.z_um = 7;
  point.sigma_100nm = 8, point.intensity_permille = 9, point.flags = 10;
  BeamRecord rejected;
  rejected.view = 1, rejected.ray = 3, rejected.a_urad = -3, rejected.b_urad = 4, rejected.reason = 5;
  const uint8_t bytes[] = {1, 0, 0, 0, 2, 0, 0, 0, 0xFD, 0xFF, 0xFF, 0xFF, 4, 0, 0, 0,  //
                           0, 0, 0, 0, 5, 0, 0, 0, 0xFA, 0xFF, 0xFF, 0xFF, 7, 0, 0, 0,  //
                           8, 0, 0, 0, 9, 0, 0, 0, 10,   0,    0,    0,                 //
                           1, 0, 0, 0, 3, 0, 0, 0, 0xFD, 0xFF, 0xFF, 0xFF, 4, 0, 0, 0,  //
                           5, 0, 0, 0};
  EXPECT_EQ(crc_of_beam(rejected, crc_of_beam(point, 0)), crc32c(bytes, sizeof bytes));
}

TEST(BeamRecord, RefusesArraysThatContradictEachOther) {
  BatchBuilder builder;
  builder.start(1, 0, 0, 0);
  for (uint32_t i = 0; i < 6; ++i) {
    BeamRecord beam;
    beam.ray = i;
    beam.reason = i % 3 == 0 ? 1u : 0u;
    ASSERT_TRUE(builder.add(beam));
  }
  BeamRecord records[kBatchBeams];
  tg_PointBatch batch = builder.batch();
  EXPECT_EQ(beams_of_batch(batch, records), 6u);
  for (auto spoil : std::vector<void (*)(tg_PointBatch&)>{
           [](tg_PointBatch& b) { --b.b_urad_count; }, [](tg_PointBatch& b) { --b.x_um_count; },
           [](tg_PointBatch& b) { --b.z_um_count; }, [](tg_PointBatch& b) { --b.sigma_100nm_count; },
           [](tg_PointBatch& b) { b.flags_count = 1; }, [](tg_PointBatch& b) { --b.rejected_reason_count; },
           [](tg_PointBatch& b) { b.rejected_beam[1] = 200; },
           [](tg_PointBatch& b) { b.rejected_reason[0] = 0; }}) {
    tg_PointBatch bad = batch;
    spoil(bad);
    EXPECT_EQ(beams_of_batch(bad, records), 0u);
  }
}

// A raster over a part as the machine measures one: 1 mm pitch at 350 mm, sigma 20 to 60 um of noise,
// intensity that varies by 10 % from spot to spot, edges, rejected beams, some flagged points.
TEST(BeamRecord, AtMostFourteenBytesAPointOnTheWire) {
  for (const double pitch_mm : {0.25, 0.5, 1.0, 2.0}) {
    for (const double slope : {0.0, 0.6, 2.0}) {  // of the surface along the row
      std::mt19937 random(5);
      std::normal_distribution<double> noise(0, 1);
      std::vector<BeamRecord> beams;
      const int columns = 90, rows = 60;
      const double step_urad = pitch_mm / (2 * 350) * 1e6;
      for (int row = 0; row < rows; ++row) {
        for (int k = 0; k < columns; ++k) {
          const int column = row % 2 == 0 ? k : columns - 1 - k;
          BeamRecord beam;
          beam.view = 17;
          beam.ray = static_cast<uint32_t>(row * columns + k);
          const auto driven = [](double urad) { return 6 * static_cast<int32_t>(std::lround(urad / 6)); };
          beam.a_urad = driven((column - columns / 2) * step_urad);
          beam.b_urad = driven((row - rows / 2) * step_urad);
          if (random() % 40 == 0) {
            beam.reason = tg_RejectReason_REJECT_WEAK;
            beams.push_back(beam);
            continue;
          }
          // A block in the middle stands 20 mm out.
          const bool block = column > 30 && column < 60 && row > 20 && row < 40;
          const double sigma_mm = (0.035 + (block ? 0.01 : 0)) * (1 + 0.05 * noise(random));
          const double y = column * pitch_mm, z = row * pitch_mm * 0.8;
          const double x = (block ? 20 : 0) + slope * y - 0.3 * z + sigma_mm * noise(random);
          beam.x_um = static_cast<int32_t>(std::lround(x * 1000));
          beam.y_um = static_cast<int32_t>(std::lround(y * 1000 + 6 * noise(random)));
          beam.z_um = static_cast<int32_t>(std::lround(z * 1000 + 0.57 * sigma_mm * 1000 * noise(random)));
          beam.sigma_100nm = static_cast<uint32_t>(std::lround(sigma_mm * 1e4));
          beam.intensity_permille = static_cast<uint32_t>(std::lround(42 * (1 + 0.1 * noise(random))));
          beam.flags = random() % 500 == 0 ? 4u : 0u;
          beams.push_back(beam);
        }
      }
      const Delivery delivery = deliver(beams);
      ASSERT_EQ(delivery.beams, beams);
      size_t points = 0;
      for (const BeamRecord& beam : beams) points += beam.reason == 0 ? 1 : 0;
      const double bytes_per_point = static_cast<double>(delivery.wire_bytes) / static_cast<double>(points);
      std::printf("pitch %.2f mm, slope %.1f: %.2f bytes a point, %.1f beams a batch\n", pitch_mm, slope,
                  bytes_per_point, static_cast<double>(beams.size()) / static_cast<double>(delivery.batches));
      EXPECT_LE(bytes_per_point, 14.0);
    }
  }
}

}  // namespace
}  // namespace tetragauge
