// SPDX-License-Identifier: Apache-2.0
// Exactly once, whatever the line does to the frames.
#include <gtest/gtest.h>

#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

struct Line {
  double lose_frame = 0, repeat_frame = 0, flip_byte = 0;
};

std::vector<BeamRecord> scan_over(const Line& line, unsigned seed) {
  TestHost host;
  host.connect();
  EXPECT_TRUE(host.home());
  host.seed(seed);
  host.lose_frame = line.lose_frame;
  host.repeat_frame = line.repeat_frame;
  host.flip_byte = line.flip_byte;
  EXPECT_TRUE(host.scan({small_view(), small_view(), small_view()}));
  const auto resume_when_paused = [&] {
    // A line this bad may look like silence; the host then resumes.
    if (host.last_beat.state == tg_State_STATE_PAUSED) {
      host.last_beat.state = tg_State_STATE_SCANNING;
      host.request(tg_HostMessage_scan_resume_tag);
    }
    return host.ended;
  };
  EXPECT_TRUE(host.run_until(resume_when_paused, 200)) << host.trouble();
  EXPECT_EQ(host.end.crc, host.crc());
  EXPECT_EQ(host.end.points + host.end.rejected, host.beams.size());
  return host.beams;
}

TEST(Delivery, ExactlyOnceOverABadLine) {
  const std::vector<BeamRecord> clean = scan_over({}, 0);
  ASSERT_EQ(clean.size(), 3 * kSmallViewRays);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_EQ(scan_over({0.2, 0, 0}, seed), clean) << "a fifth of the frames lost, seed " << seed;
    EXPECT_EQ(scan_over({0, 0.3, 0}, seed), clean) << "frames repeated, seed " << seed;
    EXPECT_EQ(scan_over({0, 0, 1e-3}, seed), clean) << "bytes flipped, seed " << seed;
    EXPECT_EQ(scan_over({0.1, 0.1, 1e-3}, seed), clean) << "all of it, seed " << seed;
  }
}

TEST(Delivery, SlowLineTakesAFewBytesAtATime) {
  TestHost host;
  host.board.line_room = 9;  // bytes for each write
  host.connect();
  ASSERT_TRUE(host.home());
  ASSERT_TRUE(host.scan({small_view()}));
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 30)) << host.trouble();
  EXPECT_EQ(host.end.crc, host.crc());
  EXPECT_EQ(host.beams.size(), kSmallViewRays);
}

tg_MachineMessage batch_of(uint32_t ray) {
  tg_MachineMessage message = tg_MachineMessage_init_zero;
  message.which_body = tg_MachineMessage_points_tag;
  message.body.points.first_ray = ray;
  return message;
}

TEST(StreamRing, SendsOnlyWithCreditAndKeepsUntilAcknowledged) {
  StreamRing ring;
  ring.start(5);
  uint32_t item = 0;
  for (uint32_t i = 0; i < kRingItems; ++i) {
    ASSERT_FALSE(ring.full());
    ASSERT_TRUE(ring.push(batch_of(i)));
  }
  EXPECT_TRUE(ring.full());
  EXPECT_FALSE(ring.next_to_send(&item)) << "no credit";
  ring.credit({4, 0, 10});
  EXPECT_FALSE(ring.next_to_send(&item)) << "credit of another plan";
  ring.credit({5, 0, 3});
  for (uint32_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(ring.next_to_send(&item));
    EXPECT_EQ(item, i);
  }
  EXPECT_FALSE(ring.next_to_send(&item));

  uint8_t first[kFrameWireBytes], again[kFrameWireBytes];
  const size_t bytes = ring.encode(1, first);
  ring.resend({5, 1, 100});
  for (uint32_t i = 1; i < 3; ++i) {
    ASSERT_TRUE(ring.next_to_send(&item));
    EXPECT_EQ(item, i) << "asked for beyond what was sent: cut";
  }
  EXPECT_FALSE(ring.next_to_send(&item));
  ASSERT_EQ(ring.encode(1, again), bytes);
  EXPECT_EQ(memcmp(first, again, bytes), 0);

  ring.credit({5, 4, 4});
  EXPECT_EQ(ring.acked(), 0u) << "what was never sent cannot be acknowledged";
  ring.credit({5, 2, 4});
  EXPECT_EQ(ring.acked(), 2u);
  EXPECT_FALSE(ring.full());
  ring.credit({5, 1, 2});
  EXPECT_EQ(ring.acked(), 2u) << "late frames change nothing";
  ring.resend({5, 0, 3});
  ASSERT_TRUE(ring.next_to_send(&item));
  EXPECT_EQ(item, 2u) << "what is acknowledged is gone";
}

}  // namespace
}  // namespace tetragauge
