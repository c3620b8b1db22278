// SPDX-License-Identifier: GPL-3.0-or-later
// Fuzzes the whole firmware on the board in memory: the bytes are a script of what the line, the inputs and
// the clock do. Whatever they do, the laser is on only in SCANNING with good inputs and a host heard within
// 500 ms, states change only along the table, and each request is answered exactly once.
//
//   0 N payload   a request with its frame, the next id       3 B  inputs: bit 0 opens the interlock, 1
//   mirrors bad, 1 N payload   an event with its frame                          2 laser bad, 3 ambient light
//   on the rail, 4 converter 2 N           N tenths of a second pass                        stuck 4 N bytes
//   bytes as they are                           5 N  the line takes N bytes at a time 6 N           N
//   milliseconds pass                         7    the last request again, same id
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>

#include "firmware/controller.hpp"
#include "firmware/hal/fake_board.hpp"

namespace {

using namespace tetragauge;

class Run {
 public:
  Run(const uint8_t* data, size_t size) : at_(data), end_(data + size) {
    controller_->begin();
    board_.when_laser_goes_on = [this] { check_laser(); };
  }

  void play() {
    // Bounded: so much script, so many events of the board.
    while (at_ < end_ && events_ < kMostEvents) {
      switch (next()) {
        case 0:
          request(take(next()));
          break;
        case 1:
          frame({Channel::kEvent, 0}, take(next()));
          break;
        case 2:
          run(next() * 0.1);
          break;
        case 3:
          break_things(next());
          break;
        case 4:
          garbage(take(next()));
          break;
        case 5:
          board_.line_room = next();
          break;
        case 6:
          run(next() * 0.001);
          break;
        case 7:
          if (last_id_ != kFirstId) ask();
          break;
        default:
          break;
      }
    }
    // The line takes everything again, so each request must have its answer by now; a self-test takes 250 ms.
    board_.line_room = 4096;
    board_.to_machine.push_back(0);
    run(0.3);
    run(0.1);
    if (board_.restart_asked || board_.bootloader_asked || events_ >= kMostEvents) return;
    for (const auto& [id, replies] : replies_) must(replies >= 1, "every request is answered");
  }

 private:
  static constexpr int kMostEvents = 20'000;
  static constexpr uint32_t kFirstId = 1000;
  using Bytes = std::basic_string<uint8_t>;

  void must(bool holds, const char* what) const {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s (state %s at %.6f s)\n", what, state_name(controller_->state()),
                 static_cast<double>(board_.now) * 1e-9);
    std::abort();
  }

  uint8_t next() { return at_ < end_ ? *at_++ : uint8_t{0}; }
  Bytes take(size_t count) {
    if (count > static_cast<size_t>(end_ - at_)) count = static_cast<size_t>(end_ - at_);
    const Bytes bytes(at_, count);
    at_ += count;
    return bytes;
  }

  void request(const Bytes& payload) {
    last_request_ = payload;
    ++last_id_;
    replies_[last_id_] = 0;
    ask();
  }
  void ask() {
    ++asked_[last_id_];
    frame({Channel::kRequest, last_id_}, last_request_);
  }
  void frame(FrameHeader header, const Bytes& payload) {
    uint8_t wire[kFrameWireBytes];
    board_.to_machine.push_back(0);  // ends what garbage may have begun
    const size_t bytes = encode_frame(header, payload.data(), payload.size(), wire);
    board_.to_machine.insert(board_.to_machine.end(), wire, wire + bytes);
    look();
  }
  void garbage(const Bytes& bytes) {
    board_.to_machine.insert(board_.to_machine.end(), bytes.begin(), bytes.end());
    look();
  }
  void break_things(uint8_t bits) {
    board_.needed_inputs = (bits & 1 ? 0 : Inputs::kInterlockClosed) | (bits & 2 ? 0 : Inputs::kMirrorsGood) |
                           (bits & 4 ? 0 : Inputs::kLaserGood);
    board_.ambient_codes = bits & 8 ? 70'000 : 100;
    board_.stuck_converter = (bits & 16) != 0;
    controller_->on_interlock();
    must(!(bits & 1) || !board_.laser, "the laser is off when the interlock's interrupt returns");
    look();
  }

  void run(double seconds) {
    const uint64_t until = board_.now + static_cast<uint64_t>(seconds * 1e9);
    look();
    while (events_ < kMostEvents && run_next(board_, *controller_, until)) look();
  }

  // After every event: poll, read the replies, check.
  void look() {
    ++events_;
    const size_t waiting = board_.to_machine.size();
    controller_->poll();
    if (board_.to_machine.size() < waiting) heard_ns_ = board_.now;
    for (uint8_t byte : board_.from_machine) {
      if (!reader_.push(byte)) continue;
      const Frame& reply = reader_.frame();
      tg_MachineMessage message = {};
      must(decode_message(reply, &message), "what the machine sends decodes");
      if (reply.header.channel != Channel::kReply) continue;
      const int replies = ++replies_[reply.header.id];
      must(replies <= asked_[reply.header.id], "no request is answered more often than it was sent");
    }
    must(reader_.bad_frames() == 0, "the machine sends good frames");
    board_.from_machine.clear();
    check_laser();
    check_state();
  }

  void check_laser() const {
    if (!board_.laser) return;
    must(controller_->state() == tg_State_STATE_SCANNING, "the laser is on in SCANNING only");
    must((board_.needed_inputs & kNeededInputs) == kNeededInputs, "and with good inputs only");
    must(board_.now - heard_ns_ < 500'000'000, "and for 500 ms after the host was last heard only");
  }
  void check_state() {
    const tg_State now = controller_->state();
    // One poll may take two steps, as from SCANNING by way of READY.
    bool reachable = now == before_ || transition_allowed(before_, now);
    for (int via = 0; via < kStates && !reachable; ++via) {
      reachable = transition_allowed(before_, static_cast<tg_State>(via)) &&
                  transition_allowed(static_cast<tg_State>(via), now);
    }
    must(reachable, "states change along the table");
    before_ = now;
  }

  const uint8_t* at_;
  const uint8_t* end_;
  FakeBoard board_;
  std::unique_ptr<Controller<FakeBoard>> controller_ = std::make_unique<Controller<FakeBoard>>(board_);
  FrameReader reader_;
  std::map<uint32_t, int> asked_, replies_;  // by request id
  Bytes last_request_;
  uint32_t last_id_ = kFirstId;
  uint64_t heard_ns_ = 0;
  int events_ = 0;
  tg_State before_ = tg_State_STATE_BOOT;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Run(data, size).play();
  return 0;
}
