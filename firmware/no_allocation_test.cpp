// SPDX-License-Identifier: Apache-2.0
// After start-up the firmware takes no memory: malloc is counted here while its own code runs, and not while
// the board (which has queues for the test's sake) or the test does. The link for the machine's processor has
// no malloc at all (arm_check); this one sees it on the host, in what the host's compiler makes of the same
// code.
#include <gtest/gtest.h>

#include <cstddef>

#include "firmware/controller.hpp"
#include "firmware/hal/fake_board.hpp"
#include "firmware/test_views.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TETRAGAUGE_MALLOC_IS_TAKEN 1
#endif

namespace {
bool counting = false;
unsigned long allocations = 0;
}  // namespace

#ifndef TETRAGAUGE_MALLOC_IS_TAKEN
extern "C" void* __libc_malloc(size_t);
extern "C" void* malloc(size_t bytes) {
  if (counting) ++allocations;
  return __libc_malloc(bytes);
}
#endif

namespace tetragauge {
namespace {

class Uncounted {
 public:
  Uncounted() : before_(counting) { counting = false; }
  ~Uncounted() { counting = before_; }

 private:
  bool before_;
};
class Counted {
 public:
  Counted() { counting = true; }
  ~Counted() { counting = false; }
};

// A FakeBoard whose own allocations are not the firmware's.
struct UncountedBoard : FakeBoard {
  void set_laser(bool on) {
    const Uncounted pause;
    FakeBoard::set_laser(on);
  }
  size_t read(uint8_t* bytes, size_t capacity) {
    const Uncounted pause;
    return FakeBoard::read(bytes, capacity);
  }
  size_t write(const uint8_t* bytes, size_t count) {
    const Uncounted pause;
    return FakeBoard::write(bytes, count);
  }
};

struct CountedFirmware {
  Controller<UncountedBoard>& controller;
  uint64_t next_poll_ns() const {
    const Counted on;
    return controller.next_poll_ns();
  }
  void on_alarm() {
    const Counted on;
    controller.on_alarm();
  }
  void on_samples() {
    const Counted on;
    controller.on_samples();
  }
  void on_step_timer(Axis axis) {
    const Counted on;
    controller.on_step_timer(axis);
  }
  void poll() {
    const Counted on;
    controller.poll();
  }
};

void send(FakeBoard& board, Channel channel, const tg_HostMessage& message) {
  static uint32_t id = 0;
  uint8_t wire[kFrameWireBytes];
  const size_t bytes = encode_message({channel, ++id}, message, wire);
  board.to_machine.insert(board.to_machine.end(), wire, wire + bytes);
}

TEST(NoAllocation, InAWholeScanAndTheServices) {
#ifdef TETRAGAUGE_MALLOC_IS_TAKEN
  GTEST_SKIP() << "the sanitizer has its own malloc";
#else
  {
    const Counted on;
    void* const one = ::operator new(8);
    ::operator delete(one);
  }
  ASSERT_EQ(allocations, 1u) << "the count counts";
  allocations = 0;

  UncountedBoard board;
  static Controller<UncountedBoard> controller(board);
  controller.begin();
  CountedFirmware firmware{controller};
  const auto ask = [&](pb_size_t tag, auto fill, double seconds) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tag;
    fill(message);
    send(board, Channel::kRequest, message);
    const uint64_t until = board.now + static_cast<uint64_t>(seconds * 1e9);
    tg_HostMessage ack = tg_HostMessage_init_zero;
    ack.which_body = tg_HostMessage_points_credit_tag;
    for (uint64_t next_ack = board.now; board.now < until; next_ack += 100'000'000) {
      ack.body.points_credit = {5, 0, 1'000};
      send(board, Channel::kEvent, ack);
      firmware.poll();
      while (run_next(board, firmware, next_ack < until ? next_ack : until)) {
      }
    }
  };
  const auto plain = [](tg_HostMessage&) {};
  ask(tg_HostMessage_hello_tag, plain, 0.1);
  ask(tg_HostMessage_self_test_tag, plain, 0.3);
  ask(tg_HostMessage_home_tag, plain, 30);
  ASSERT_EQ(controller.state(), tg_State_STATE_READY);
  ask(tg_HostMessage_calibration_commit_tag, plain, 0.1);
  ask(tg_HostMessage_home_tag, plain, 30);
  ask(
      tg_HostMessage_scan_load_tag,
      [](tg_HostMessage& message) {
        message.body.scan_load.plan_id = 5;
        message.body.scan_load.total_views = message.body.scan_load.views_count = 1;
        message.body.scan_load.views[0] = small_view();
      },
      0.1);
  ask(
      tg_HostMessage_scan_start_tag, [](tg_HostMessage& message) { message.body.scan_start.plan_id = 5; },
      20);
  EXPECT_EQ(board.times_laser_on, kSmallViewRays);
  EXPECT_EQ(controller.state(), tg_State_STATE_READY);
  ask(tg_HostMessage_get_stats_tag, plain, 0.1);
  EXPECT_EQ(allocations, 0u);
#endif
}

}  // namespace
}  // namespace tetragauge
