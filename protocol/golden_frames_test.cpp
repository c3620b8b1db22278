// SPDX-License-Identifier: Apache-2.0
// One frame of every message of protocol version 1, made by Google's protobuf for Python with CRC and COBS
// written separately. They must decode, and encode again to the same bytes, for as long as version 1 is
// spoken. A new field gets a new frame beside the old one; these never change.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "protocol/beam_record.hpp"
#include "protocol/message.hpp"

namespace tetragauge {
namespace {

struct Golden {
  const char* name;
  int channel;
  uint32_t id;
  bool from_host;
  const char* hex;
};

// clang-format off
const Golden kGolden[] = {
{"hello", 1, 7, true,
 "03010701010f0a08080110effdb6f50d432d61cf00"},
{"get_status", 1, 8, true,
 "0301080101021205d59fbbab00"},
{"heartbeat_ack", 3, 0, true,
 "02030101010a1a0308ac02fbc3326d00"},
{"clear_fault", 1, 9, true,
 "03010901010222054fe6c50400"},
{"get_config", 1, 10, true,
 "03010a0101092a02080439127f1400"},
{"set_config", 1, 11, true,
 "03010b01010832332a310a120901010101010449c01101010101010649c0121b090101010101044940110101010101044940190101010108106940ed593c8e00"},
{"home", 1, 12, true,
 "03010c0101023a051888d1fb00"},
{"scan_load", 1, 13, true,
 "03010d01012c4225080510081809221d08ff94f52a1080d30e18bfa907209ffe0a28a81630a8163855407f4828bee9757b00"},
{"scan_start", 1, 14, true,
 "03010e0101094a0208053b588abb00"},
{"scan_pause", 1, 15, true,
 "03010f01010252057ca5e5d200"},
{"scan_resume", 1, 16, true,
 "0301100101025a0548b2b26900"},
{"scan_abort", 1, 17, true,
 "03011101010262056a08d85b00"},
{"points_credit", 3, 1, true,
 "03030101010d6a060805100318235b02dd4400"},
{"points_resend", 3, 2, true,
 "03030201010d7206080510041802d11a247700"},
{"hello_reply", 2, 7, false,
 "0302070101350a2e080110effdb6f50d1a05302e312e302208656d756c617465642803304d380140800248f8acd1910150b0ea0158201839ffe300"},
{"status", 2, 8, false,
 "03020801013e1237080710021880e497d0122081e497d012289f9c0130093801400548055009580360e8076828702778028001f8acd191018801904e9001055b12f40e00"},
{"heartbeat", 3, 5, false,
 "0303050101191a1208ac021005208087a70e28053028380340094d35366600"},
{"done", 2, 12, false,
 "03020c010102220579cf05e100"},
{"refused", 2, 14, false,
 "03020e0101112a0a080110011a0449444c45cc379fd600"},
{"config", 2, 10, false,
 "03020a0101263232223008d804102818c03e2064283c30ac0238bcff0140c0b80249333333333333d33f5101010101010e204058c80160a08d06b4b3d53400"},
{"fault", 3, 6, false,
 "03030601010e3a07080110959aef3aac06296000"},
{"points", 4, 39, false,
 "03042701011942420805100318e60720ff94f52a2880d30e3205a816a816043a040b20a8164203a313064a05a08d06cf0f5204d0c4180e5a03c00507620254026a020c027201017a0101d6dd75f200"},
{"scan_end", 4, 40, false,
 "0304280101204a1908051001180120c0c407289506308de0fbd70c38808c8d9e02e47af01200"},
};
// clang-format on

std::vector<uint8_t> bytes_of(const char* hex) {
  std::vector<uint8_t> bytes;
  for (; *hex != '\0'; hex += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(std::string(hex, 2), nullptr, 16)));
  }
  return bytes;
}

const Golden& golden(const std::string& name) {
  for (const Golden& one : kGolden) {
    if (one.name == name) return one;
  }
  throw std::out_of_range(name);
}

template <class Message>
Message decoded(const Golden& one) {
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
void expect_same_bytes(const Golden& one) {
  const Message message = decoded<Message>(one);
  uint8_t wire[kFrameWireBytes];
  const size_t size = encode_message({static_cast<Channel>(one.channel), one.id}, message, wire);
  EXPECT_EQ(std::vector<uint8_t>(wire, wire + size), bytes_of(one.hex)) << one.name;
}

TEST(GoldenFrames, DecodeAndEncodeToTheSameBytes) {
  for (const Golden& one : kGolden) {
    if (one.from_host)
      expect_same_bytes<tg_HostMessage>(one);
    else
      expect_same_bytes<tg_MachineMessage>(one);
  }
}

TEST(GoldenFrames, EveryMessageHasOne) {
  std::set<uint32_t> host, machine;
  for (const Golden& one : kGolden) {
    if (one.from_host)
      host.insert(decoded<tg_HostMessage>(one).which_body);
    else
      machine.insert(decoded<tg_MachineMessage>(one).which_body);
  }
  EXPECT_EQ(host.size(), 14u);
  EXPECT_EQ(machine.size(), 9u);
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
  for (const Golden& one : kGolden) {
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

}  // namespace
}  // namespace tetragauge
