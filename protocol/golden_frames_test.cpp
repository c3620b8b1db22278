// SPDX-License-Identifier: Apache-2.0
#include "protocol/golden_frames.hpp"

#include <gtest/gtest.h>

#include <pb_common.h>

#include <set>
#include <string>
#include <vector>

#include "protocol/beam_record.hpp"
#include "protocol/message.hpp"

namespace tetragauge {
namespace {

std::vector<uint8_t> bytes_of(const char* hex) {
  std::vector<uint8_t> bytes;
  for (; *hex != '\0'; hex += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(std::string(hex, 2), nullptr, 16)));
  }
  return bytes;
}

const GoldenFrame& golden(const std::string& name) {
  for (const GoldenFrame& one : kGoldenFrames) {
    if (one.name == name) return one;
  }
  throw std::out_of_range(name);
}

template <class Message>
Message decoded(const GoldenFrame& one) {
  FrameReader reader;
  Message message = {};
  int frames = 0;
  for (uint8_t byte : bytes_of(one.hex)) {
    if (!reader.push(byte)) continue;
    ++frames;
    EXPECT_EQ(static_cast<int>(reader.frame().header.channel), one.channel) << one.name;
    EXPECT_EQ(reader.frame().header.id, one.id) << one.name;
    EXPECT_TRUE(decode_message(reader.frame(), &message)) << one.name;
  }
  EXPECT_EQ(frames, 1) << one.name;
  return message;
}

template <class Message>
void expect_same_bytes(const GoldenFrame& one) {
  const Message message = decoded<Message>(one);
  uint8_t wire[kFrameWireBytes];
  const size_t size = encode_message({static_cast<Channel>(one.channel), one.id}, message, wire);
  EXPECT_EQ(std::vector<uint8_t>(wire, wire + size), bytes_of(one.hex)) << one.name;
}

TEST(GoldenFrames, DecodeAndEncodeToTheSameBytes) {
  for (const GoldenFrame& one : kGoldenFrames) {
    if (one.from_host)
      expect_same_bytes<tg_HostMessage>(one);
    else
      expect_same_bytes<tg_MachineMessage>(one);
  }
}

std::set<uint32_t> tags_of(const pb_msgdesc_t* envelope) {
  std::set<uint32_t> tags;
  pb_field_iter_t field;
  if (!pb_field_iter_begin(&field, envelope, nullptr)) return tags;
  do {
    tags.insert(field.tag);
  } while (pb_field_iter_next(&field));
  return tags;
}

TEST(GoldenFrames, EveryMessageHasOne) {
  std::set<uint32_t> host, machine;
  for (const GoldenFrame& one : kGoldenFrames) {
    if (one.from_host)
      host.insert(decoded<tg_HostMessage>(one).which_body);
    else
      machine.insert(decoded<tg_MachineMessage>(one).which_body);
  }
  // The envelopes' own field lists are the oracle of which messages there are.
  EXPECT_EQ(host, tags_of(tg_HostMessage_fields));
  EXPECT_EQ(machine, tags_of(tg_MachineMessage_fields));
}

TEST(GoldenFrames, MeanWhatTheySay) {
  const auto hello = decoded<tg_HostMessage>(golden("hello"));
  ASSERT_EQ(hello.which_body, tg_HostMessage_hello_tag);
  EXPECT_EQ(hello.body.hello.schema_hash, 0xDEADBEEFu);

  const auto load = decoded<tg_HostMessage>(golden("scan_load"));
  ASSERT_EQ(load.which_body, tg_HostMessage_scan_load_tag);
  ASSERT_EQ(load.body.scan_load.views_count, 1u);
  EXPECT_EQ(load.body.scan_load.views[0].table_udeg, -45'000'000);
  EXPECT_EQ(load.body.scan_load.views[0].samples, 40u);

  const auto volume = decoded<tg_HostMessage>(golden("set_config"));
  ASSERT_EQ(volume.body.set_config.which_part, tg_Config_volume_tag);
  EXPECT_EQ(volume.body.set_config.part.volume.max_mm.z, 200.5);

  const auto status = decoded<tg_MachineMessage>(golden("status"));
  EXPECT_EQ(status.body.status.state, tg_State_STATE_FAULT);
  EXPECT_EQ(status.body.status.fault_clock_us, 5'000'000'000u);
  EXPECT_EQ(status.body.status.slide_um, -5);

  const auto end = decoded<tg_MachineMessage>(golden("scan_end"));
  EXPECT_TRUE(end.body.scan_end.aborted);
  EXPECT_EQ(end.body.scan_end.crc, 0xCAFEF00Du);

  const auto rays = decoded<tg_HostMessage>(golden("measure_rays")).body.measure_rays;
  EXPECT_EQ(rays.view, 1u);
  EXPECT_TRUE(rays.raw);
  ASSERT_EQ(rays.a_urad_count, 2u);
  EXPECT_EQ(rays.a_urad[0], -15'000);
  EXPECT_EQ(rays.b_urad[1], -3);

  const auto chunk = decoded<tg_HostMessage>(golden("calibration_write")).body.calibration_write;
  EXPECT_EQ(chunk.offset, 256u);
  ASSERT_EQ(chunk.data.size, 4u);
  EXPECT_EQ(chunk.data.bytes[0], 0u);
  EXPECT_EQ(chunk.data.bytes[3], 0xFFu);

  const auto stage = decoded<tg_HostMessage>(golden("set_config_stage")).body.set_config.part.stage;
  EXPECT_EQ(stage.slide.jerk, 360'000u);
  EXPECT_EQ(stage.table.home_steps, -18'100);

  const auto calibrated = decoded<tg_MachineMessage>(golden("hello_reply_calibrated")).body.hello_reply;
  EXPECT_STREQ(calibrated.calibration_id, "2026-11-03 ball plate 7");
  EXPECT_EQ(calibrated.u_cal_100nm, 73u);
  EXPECT_EQ(calibrated.reset_cause, tg_ResetCause_RESET_SOFTWARE);

  const auto camera = decoded<tg_MachineMessage>(golden("config_camera")).body.config.part.camera;
  EXPECT_EQ(camera.detector, tg_DetectorType_DETECTOR_TETRALATERAL);
  EXPECT_EQ(camera.distortion_x[3], 0.5);
  EXPECT_EQ(camera.distortion_y[6], -0.5);

  const auto test = decoded<tg_MachineMessage>(golden("self_test_reply")).body.self_test;
  ASSERT_EQ(test.items_count, 3u);
  EXPECT_EQ(test.items[0].result, tg_SelfTestResult_SELF_TEST_FAILED);
  EXPECT_EQ(test.items[1].limit, 45'000);
  EXPECT_EQ(test.items[2].check, tg_SelfTestCheck_CHECK_TRANSPORT);

  const auto stats = decoded<tg_MachineMessage>(golden("stats")).body.stats;
  ASSERT_EQ(stats.rejected_count, 6u);
  EXPECT_EQ(stats.rejected[tg_RejectReason_REJECT_AMBIENT], 3u);
  EXPECT_EQ(stats.longest_poll_us, 950u);

  const auto raw = decoded<tg_MachineMessage>(golden("raw_samples")).body.raw_samples;
  ASSERT_EQ(raw.codes_count, 16u);
  EXPECT_EQ(raw.codes[0], 15'000);
  EXPECT_EQ(raw.codes[8], -3);

  const auto points = decoded<tg_MachineMessage>(golden("points"));
  BeamRecord beams[kBatchBeams];
  ASSERT_EQ(beams_of_batch(points.body.points, beams), 3u);
  EXPECT_EQ(beams[0].x_um, -1234);
  EXPECT_EQ(beams[0].ray, 998u);
  EXPECT_EQ(beams[1].reason, static_cast<uint32_t>(tg_RejectReason_REJECT_WEAK));
  EXPECT_EQ(beams[1].a_urad, 2856);
  EXPECT_EQ(beams[2].x_um, -1231);
  EXPECT_EQ(beams[2].y_um, 49'000);
  EXPECT_EQ(beams[2].z_um, 201'007);
  EXPECT_EQ(beams[2].sigma_100nm, 348u);
  EXPECT_EQ(beams[2].flags, static_cast<uint32_t>(tg_PointFlag_POINT_ONE_CAMERA));
  EXPECT_EQ(beams[2].b_urad, 1422);
}

// Cut short at every length, and with every byte changed: refused, or decoded to something, never out of
// bounds (the sanitizer build watches).
TEST(GoldenFrames, SpoiledPayloadsDoNoHarm) {
  for (const GoldenFrame& one : kGoldenFrames) {
    FrameReader reader;
    for (uint8_t byte : bytes_of(one.hex)) {
      if (!reader.push(byte)) continue;
      const Frame& frame = reader.frame();
      std::vector<uint8_t> payload(frame.payload, frame.payload + frame.payload_bytes);
      const auto try_it = [&](const std::vector<uint8_t>& bytes) {
        const Frame spoiled{frame.header, bytes.data(), bytes.size()};
        tg_HostMessage host = {};
        tg_MachineMessage machine = {};
        decode_message(spoiled, &host);
        if (decode_message(spoiled, &machine) && machine.which_body == tg_MachineMessage_points_tag) {
          BeamRecord beams[kBatchBeams];
          EXPECT_LE(beams_of_batch(machine.body.points, beams), kBatchBeams);
        }
      };
      for (size_t size = 0; size < payload.size(); ++size) {
        try_it(std::vector<uint8_t>(payload.begin(), payload.begin() + static_cast<long>(size)));
        for (int value = 0; value < 256; ++value) {
          std::vector<uint8_t> changed = payload;
          changed[size] = static_cast<uint8_t>(value);
          try_it(changed);
        }
      }
    }
  }
}

TEST(DecodeMessage, RefusesAValueItsEnumerationDoesNotHave) {
  const auto decodes = [](std::initializer_list<uint8_t> payload, auto message) {
    Frame frame;
    frame.payload_bytes = payload.size();
    frame.payload = payload.begin();
    return decode_message(frame, &message);
  };
  const tg_HostMessage host = tg_HostMessage_init_zero;
  const tg_MachineMessage machine = tg_MachineMessage_init_zero;
  EXPECT_TRUE(decodes({0x2a, 2, 8, 6}, host)) << "GetConfig: CONFIG_VOLUME";
  EXPECT_FALSE(decodes({0x2a, 2, 8, 7}, host));
  EXPECT_FALSE(decodes({0x2a, 2, 8, 16}, host));
  EXPECT_FALSE(decodes({0x2a, 11, 8, 255, 255, 255, 255, 255, 255, 255, 255, 255, 1}, host)) << "-1";
  EXPECT_TRUE(decodes({0x3a, 2, 8, 10}, machine)) << "Fault: FAULT_STORAGE";
  EXPECT_FALSE(decodes({0x3a, 2, 8, 11}, machine));
}

}  // namespace
}  // namespace tetragauge
