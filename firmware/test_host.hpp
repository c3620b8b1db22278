// SPDX-License-Identifier: Apache-2.0
// A host in a few lines, for the firmware's tests: speaks the protocol to a controller on a FakeBoard, over a
// line that may lose, flip and repeat bytes or whole frames.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/controller.hpp"
#include "firmware/hal/fake_board.hpp"
#include "protocol/state_name.hpp"

namespace tetragauge {

class TestHost {
 public:
  TestHost() : controller(std::make_unique<Controller<FakeBoard>>(board)) { controller->begin(); }

  FakeBoard board;
  std::unique_ptr<Controller<FakeBoard>> controller;

  // What has come from the machine.
  std::map<uint32_t, tg_MachineMessage> replies;
  std::map<uint32_t, uint32_t> times_replied;  // by request id
  uint64_t last_sent_ns = 0;                   // the last frame that left whole
  std::vector<BeamRecord> beams;
  struct Raw {
    size_t beams_before;
    tg_RawSamples item;
  };
  std::vector<Raw> raw;
  tg_ScanEnd end = tg_ScanEnd_init_zero;
  bool ended = false;
  std::vector<tg_Fault> faults;
  tg_Heartbeat last_beat = tg_Heartbeat_init_zero;
  uint32_t items = 0;

  // How it behaves.
  bool answers_heartbeats = true, credits = true;
  uint32_t credit_window = 8;
  double lose_frame = 0, repeat_frame = 0, flip_byte = 0;  // both ways, probabilities
  std::function<void()> after_every_event = [] {};

  uint32_t request(tg_HostMessage message) {
    const uint32_t id = next_id_++;
    transmit({Channel::kRequest, id}, message);
    return id;
  }
  uint32_t request(pb_size_t tag) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tag;
    return request(message);
  }

  // Repeats the same request, with its id, until it is answered.
  tg_MachineMessage ask(const tg_HostMessage& message) {
    const uint32_t id = next_id_++;
    for (int attempt = 0; attempt < 50; ++attempt) {
      transmit({Channel::kRequest, id}, message);
      if (run_until([&] { return replies.contains(id); }, 0.05)) return replies[id];
    }
    return tg_MachineMessage_init_zero;
  }
  tg_MachineMessage ask(pb_size_t tag) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tag;
    return ask(message);
  }
  bool accepted(pb_size_t tag) { return ask(tag).which_body == tg_MachineMessage_done_tag; }

  void connect() {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_hello_tag;
    message.body.hello = {kProtocolVersion, kSchemaHash};
    ask(message);
  }
  bool home() {
    return accepted(tg_HostMessage_home_tag) &&
           run_until([&] { return controller->state() == tg_State_STATE_READY; }, 60);
  }
  bool load(const std::vector<tg_View>& views) {
    plan_id_ += 1;
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_scan_load_tag;
    tg_ScanLoad& chunk = message.body.scan_load;
    chunk.plan_id = plan_id_;
    chunk.total_views = static_cast<uint32_t>(views.size());
    for (size_t i = 0; i < views.size(); ++i) {
      if (chunk.views_count == 0) chunk.first_view = static_cast<uint32_t>(i);
      chunk.views[chunk.views_count++] = views[i];
      if (chunk.views_count == 8 || i + 1 == views.size()) {
        if (ask(message).which_body != tg_MachineMessage_done_tag) return false;
        chunk.views_count = 0;
      }
    }
    begin_stream(plan_id_);
    return true;
  }
  bool start() {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_scan_start_tag;
    message.body.scan_start.plan_id = plan_id_;
    if (credits) send_credit();
    return ask(message).which_body == tg_MachineMessage_done_tag;
  }
  bool scan(const std::vector<tg_View>& views) { return load(views) && start(); }

  bool run_until(const std::function<bool()>& reached, double seconds) {
    const uint64_t until = board.now + static_cast<uint64_t>(seconds * 1e9);
    controller->poll();
    listen();
    while (!reached()) {
      if (!run_next(board, *controller, until)) return reached();
      listen();
      after_every_event();
    }
    return true;
  }
  void run(double seconds) {
    run_until([] { return false; }, seconds);
  }

  void send_credit() {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_points_credit_tag;
    message.body.points_credit = {plan_id_, items, items + credit_window};
    transmit({Channel::kEvent, 0}, message);
  }

  // A plan is loaded: what comes next is its stream.
  void begin_stream(uint32_t plan_id) {
    plan_id_ = plan_id;
    beams.clear();
    raw.clear();
    items = 0;
    ended = false;
  }

  uint32_t crc() const {
    uint32_t crc = 0;
    for (const BeamRecord& beam : beams) crc = crc_of_beam(beam, crc);
    return crc;
  }
  uint32_t plan_id() const { return plan_id_; }
  void seed(unsigned seed) { random_.seed(seed); }

  std::string trouble() const {
    std::ostringstream out;
    out << "state " << state_name(controller->state()) << ", " << beams.size() << " beams, " << items
        << " items, faults";
    for (const tg_Fault& fault : faults) out << ' ' << fault.code;
    return out.str();
  }

  void transmit(FrameHeader header, const tg_HostMessage& message) {
    uint8_t wire[kFrameWireBytes];
    const size_t bytes = encode_message(header, message, wire);
    if (chance(lose_frame)) return;
    last_sent_ns = board.now;
    const int times = chance(repeat_frame) ? 2 : 1;
    for (int k = 0; k < times; ++k) {
      for (size_t i = 0; i < bytes; ++i) board.to_machine.push_back(spoiled(wire[i]));
    }
  }

 private:
  bool chance(double p) { return p > 0 && std::uniform_real_distribution<double>(0, 1)(random_) < p; }
  uint8_t spoiled(uint8_t byte) {
    return chance(flip_byte) ? static_cast<uint8_t>(byte ^ (1u << (random_() % 8))) : byte;
  }

  void listen() {
    std::vector<uint8_t> bytes;
    bytes.swap(board.from_machine);
    for (uint8_t byte : bytes) {
      if (!reader_.push(spoiled(byte)) || chance(lose_frame)) continue;
      tg_MachineMessage message = tg_MachineMessage_init_zero;
      if (!decode_message(reader_.frame(), &message)) continue;
      hear(reader_.frame().header, message);
    }
  }

  void hear(FrameHeader header, const tg_MachineMessage& message) {
    if (header.channel == Channel::kReply) {
      replies[header.id] = message;
      ++times_replied[header.id];
    } else if (message.which_body == tg_MachineMessage_fault_tag) {
      faults.push_back(message.body.fault);
    } else if (message.which_body == tg_MachineMessage_heartbeat_tag) {
      last_beat = message.body.heartbeat;
      if (!answers_heartbeats) return;
      tg_HostMessage ack = tg_HostMessage_init_zero;
      ack.which_body = tg_HostMessage_heartbeat_ack_tag;
      ack.body.heartbeat_ack.counter = last_beat.counter;
      transmit({Channel::kEvent, 0}, ack);
      if (last_beat.plan_id == plan_id_ && last_beat.stream_next > items) ask_again(last_beat.stream_next);
      if (credits) send_credit();
    } else if (header.channel == Channel::kStream) {
      hear_item(header.id, message);
    }
    if (header.channel != Channel::kReply) controller->poll();
  }

  void ask_again(uint32_t end) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_points_resend_tag;
    message.body.points_resend = {plan_id_, items, end - items};
    transmit({Channel::kEvent, 0}, message);
  }

  void hear_item(uint32_t number, const tg_MachineMessage& message) {
    if (number > items) ask_again(number + 1);
    if (number != items) return;
    if (message.which_body == tg_MachineMessage_points_tag) {
      BeamRecord records[kBatchBeams];
      const uint32_t count = beams_of_batch(message.body.points, records);
      beams.insert(beams.end(), records, records + count);
    } else if (message.which_body == tg_MachineMessage_raw_samples_tag) {
      raw.push_back({beams.size(), message.body.raw_samples});
    } else {
      end = message.body.scan_end;
      ended = true;
    }
    ++items;
    if (credits) send_credit();
  }

  FrameReader reader_;
  std::mt19937 random_{20260101};
  uint32_t next_id_ = 100;
  uint32_t plan_id_ = 40;
};

}  // namespace tetragauge
