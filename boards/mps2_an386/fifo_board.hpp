// SPDX-License-Identifier: Apache-2.0
// The firmware's Board on the other end of the bus: what the firmware does is gathered and goes to the world
// with the end of its turn, or with a question.
#pragma once

#include <cstring>

#include "boards/cortex_m4/startup.hpp"
#include "boards/mps2_an386/fifo_link.hpp"
#include "firmware/hal/board.hpp"

namespace tetragauge {

template <class Bus>
class FifoBoard : public Storage {
 public:
  static constexpr const char* kName = "mps2_an386";
  static constexpr uint32_t kCapabilities =
      tg_Capability_CAPABILITY_EMULATED | tg_Capability_CAPABILITY_ADC_16_BIT;
  static constexpr uint32_t kSamplePeriodNs = mps2_bus::kSamplePeriodNs;
  static constexpr int32_t kMirrorCodeStep = mps2_bus::kMirrorCodeStep;
  static constexpr int32_t kMirrorReachUrad = 32'767 * kUradPerMirrorCode;
  static constexpr uint32_t kStepTicksPerSecond = mps2_bus::kStepTicksPerSecond;

  void begin() { link_.begin(); }

  // ---------------------------------------------------------------- turns

  // Waits for what comes next. After a start the board is as at power-on.
  mps2_bus::Call next_call() {
    take(&says_);
    link_.start_ticks();
    if (says_.call == mps2_bus::Call::start) {
      boot_id_ = says_.values[0];
      reset_cause_ = static_cast<tg_ResetCause>(says_.values[1]);
      bank_words_ = says_.values[2];
      actions_ = 0;
      pending_[0] = pending_[1] = false;
    }
    if (says_.samples > 0) link_.receive(burst_, says_.samples * sizeof(PsdSample));
    line_at_ = 0;
    line_bytes_ = says_.line_bytes;
    link_.receive(line_, line_bytes_);
    if (says_.call == mps2_bus::Call::table_step) pending_[0] = false;
    if (says_.call == mps2_bus::Call::slide_step) pending_[1] = false;
    return says_.call;
  }
  // `report`: state, fault, view, resting and next poll of the firmware.
  void finish(mps2_bus::ImageSays report) { say(report, nullptr); }

  // ---------------------------------------------------------------- Board (hal/board.hpp)

  uint32_t boot_id() const { return boot_id_; }
  uint64_t now_ns() const { return says_.now_ns; }
  void set_alarm_ns(uint64_t time_ns) { act({.what = Action::What::alarm, .value = time_ns}); }
  void set_mirrors(int16_t a_code, int16_t b_code) {
    act({.what = Action::What::mirrors, .a = a_code, .b = b_code});
    // A mirror that stood off its place may stand right now.
    inputs_known_ = false;
  }
  void set_laser(bool on) { act({.what = Action::What::laser, .a = on}); }
  void start_samples(PsdSample* samples, uint32_t count) {
    burst_ = samples;
    act({.what = Action::What::samples, .a = static_cast<int16_t>(count)});
  }
  uint64_t step_clock() const { return says_.now_ns; }
  bool schedule_step(Axis axis, uint64_t tick, int direction) {
    pending_[static_cast<int>(axis)] = true;
    act({.what = Action::What::step,
         .axis = static_cast<uint8_t>(axis),
         .a = static_cast<int16_t>(direction),
         .value = tick});
    return tick >= says_.now_ns;
  }
  bool cancel_step(Axis axis) {
    const bool still_to_come = pending_[static_cast<int>(axis)];
    pending_[static_cast<int>(axis)] = false;
    act({.what = Action::What::cancel_step, .axis = static_cast<uint8_t>(axis)});
    return still_to_come;
  }
  uint32_t inputs() const {
    if (!inputs_known_) ask({.question = Question::inputs});
    return says_.inputs;
  }
  size_t read(uint8_t* bytes, size_t capacity) {
    const size_t left = line_bytes_ - line_at_;
    const size_t count = left < capacity ? left : capacity;
    std::memcpy(bytes, line_ + line_at_, count);
    line_at_ += count;
    return count;
  }
  size_t write(const uint8_t* bytes, size_t count) {
    return ask({.question = Question::line_write, .payload_bytes = static_cast<uint32_t>(count)}, bytes);
  }
  void mask_interrupts(bool) {}  // they come with the turns, from the main loop
  void kick_watchdog() {}        // who waits for the turn's end watches
  Storage& storage() { return *this; }
  tg_ResetCause reset_cause() const { return reset_cause_; }
  void restart(bool into_bootloader) { act({.what = Action::What::restart, .a = into_bootloader}); }
  uint32_t stack_free_bytes() const { return stack_never_used_bytes(); }
  bool self_check(tg_SelfTestCheck, tg_SelfTestItem*) { return false; }

  // ---------------------------------------------------------------- Storage

  uint32_t bank_words() const override { return bank_words_; }
  bool erase(uint32_t bank) override {
    return ask({.question = Question::store_erase, .values = {bank}}) != 0;
  }
  bool write(uint32_t bank, uint32_t first_word, const uint32_t* words, uint32_t count) override {
    for (uint32_t done = 0; done < count; done += mps2_bus::kMostStoreWords) {
      const uint32_t now = part_of(count - done);
      if (ask({.question = Question::store_write,
               .payload_bytes = now * 4,
               .values = {bank, first_word + done, now}},
              words + done) == 0)
        return false;
    }
    return true;
  }
  bool busy() const override { return says_.store_busy != 0; }
  void read(uint32_t bank, uint32_t first_word, uint32_t* words, uint32_t count) const override {
    for (uint32_t done = 0; done < count; done += mps2_bus::kMostStoreWords) {
      const uint32_t now = part_of(count - done);
      ask({.question = Question::store_read, .values = {bank, first_word + done, now}});
      link_.receive(words + done, now * 4);
    }
  }

 private:
  using Action = mps2_bus::Action;
  using Question = mps2_bus::Question;

  static uint32_t part_of(uint32_t words) {
    return words < mps2_bus::kMostStoreWords ? words : mps2_bus::kMostStoreWords;
  }

  void act(const Action& action) {
    if (actions_ == mps2_bus::kMostActions) ask({.question = Question::inputs});
    out_.actions[actions_++] = action;
  }

  // What it reads of the world is news, not a change of this board: hence const.
  uint32_t ask(const mps2_bus::ImageSays& question, const void* payload = nullptr) const {
    say(question, payload);
    take(&says_);
    return says_.values[0];
  }
  void say(const mps2_bus::ImageSays& what, const void* payload) const {
    out_.says = what;
    out_.says.actions = static_cast<uint16_t>(actions_);
    out_.says.ticks = link_.ticks();
    actions_ = 0;
    link_.send(&out_, sizeof out_.says + out_.says.actions * sizeof(Action));
    if (what.payload_bytes > 0) link_.send(payload, what.payload_bytes);
  }
  void take(mps2_bus::WorldSays* says) const {
    link_.receive(says, sizeof *says);
    inputs_known_ = true;
  }

  mutable FifoLink<Bus> link_;
  mutable mps2_bus::WorldSays says_ = {};
  mutable struct {
    mps2_bus::ImageSays says;
    Action actions[mps2_bus::kMostActions];
  } out_ = {};
  mutable uint32_t actions_ = 0;
  mutable bool inputs_known_ = false;
  uint32_t boot_id_ = 0, bank_words_ = 0;
  tg_ResetCause reset_cause_ = tg_ResetCause_RESET_POWER;
  bool pending_[kAxes] = {};
  PsdSample* burst_ = nullptr;
  uint8_t line_[mps2_bus::kMostLineBytes];
  size_t line_at_ = 0, line_bytes_ = 0;
};

}  // namespace tetragauge
