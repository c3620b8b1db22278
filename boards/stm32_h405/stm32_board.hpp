// SPDX-License-Identifier: Apache-2.0
// The Olimex STM32-H405 (STM32F405RG) as the firmware's Board: one peripheral each, put together.
//
//   Stm32Board<ChipBus, BuiltInMirrors> board;
//   board.begin();                                 // before the controller
//   the interrupts: image/main.cpp
#pragma once

#include "boards/cortex_m4/core.hpp"
#include "boards/stm32_h405/alarm_clock.hpp"
#include "boards/stm32_h405/boot_id.hpp"
#include "boards/stm32_h405/clock_check.hpp"
#include "boards/stm32_h405/flash_storage.hpp"
#include "boards/stm32_h405/input_pins.hpp"
#include "boards/stm32_h405/laser_switch.hpp"
#include "boards/stm32_h405/mirrors.hpp"
#include "boards/stm32_h405/reset_cause.hpp"
#include "boards/stm32_h405/sampler.hpp"
#include "boards/stm32_h405/serial_line.hpp"
#include "boards/stm32_h405/start_clocks.hpp"
#include "boards/stm32_h405/step_timer.hpp"
#include "boards/stm32_h405/watchdog.hpp"
#include "firmware/hal/board.hpp"

namespace tetragauge {

// Of interrupts, 0 first. The controller's are held back from kStepPriority down (mask_interrupts), all but
// the line's.
inline constexpr uint32_t kLinePriority = 0, kStepPriority = 1, kInterlockPriority = 2, kMeasurePriority = 3,
                          kTickPriority = 15;

// What the start-up code leaves for the board.
struct StartInfo {
  uint32_t* kept;  // a cell that no start clears
  void (*restart)(bool into_bootloader);
  uint32_t (*stack_free_bytes)();
};

template <class Bus, template <class> class Mirrors>
class Stm32Board {
 public:
  static constexpr const char* kName = "stm32_h405";
  static constexpr uint32_t kCapabilities = 0;
  static constexpr uint32_t kSamplePeriodNs = 1'000'000'000 / clock_tree::kSampleHz;
  static constexpr uint32_t kStepTicksPerSecond = clock_tree::kApb1TimerHz;
  static constexpr int32_t kMirrorCodeStep = Mirrors<Bus>::kCodeStep;
  static constexpr int32_t kMirrorReachUrad = Mirrors<Bus>::kReachUrad;

  explicit Stm32Board(const StartInfo& start) : start_(start), storage_(faults_) {}

  void begin() {
    start_clocks<Bus>(faults_);
    rcc::switch_on<Bus>(rcc::kGpioAOn(1) | rcc::kGpioBOn(1) | rcc::kGpioCOn(1) | rcc::kDma2On(1));
    rcc::switch_on<Bus>(rcc::kTim2On(1) | rcc::kTim4On(1) | rcc::kTim5On(1) | rcc::kSpi2On(1) |
                        rcc::kDacOn(1));
    rcc::switch_on<Bus>(rcc::kTim8On(1) | rcc::kUsart1On(1) | rcc::kAdc1On(1) | rcc::kAdc2On(1) |
                        rcc::kSyscfgOn(1));
    laser_.begin();
    reset_cause_ = take_reset_cause<Bus>();
    boot_id_ = make_boot_id<Bus>(start_.kept, faults_);
    pins::Light::output<Bus>();
    pins::FastLine::input<Bus>();
    const bool dma = dma_works<Bus>(kDmaTurns);
    if (!dma) faults_.add(WaitFault::kDma);
    const uint32_t baud = pins::FastLine::high<Bus>() ? clock_tree::kFastBaud : clock_tree::kBaud;
    line_.begin(clock_tree::usart_divider(baud), dma);
    clock_.begin();
    steps_.begin();
    mirrors_.begin(faults_);
    sampler_.begin();
    inputs_.begin();
    core::enable_interrupt<Bus, usart1::kInterrupt>(kLinePriority);
    core::enable_interrupt<Bus, dma2::interrupt_of(7)>(kLinePriority);
    core::enable_interrupt<Bus, Tim2::kInterrupt>(kStepPriority);
    core::enable_interrupt<Bus, Tim4::kInterrupt>(kInterlockPriority);
    core::enable_interrupt<Bus, Tim5::kInterrupt>(kMeasurePriority);
    core::enable_interrupt<Bus, dma2::interrupt_of(0)>(kMeasurePriority);
    core::start_systick<Bus>(clock_tree::kCoreHz / 1000, kTickPriority);
    watchdog_.begin(faults_);
  }

  // ---------------------------------------------------------------- Board (hal/board.hpp)

  uint32_t boot_id() const { return boot_id_; }
  uint64_t now_ns() const { return clock_.now_ns(); }
  void set_alarm_ns(uint64_t time_ns) { clock_.set_alarm_ns(time_ns); }
  void set_mirrors(int16_t a_code, int16_t b_code) { mirrors_.set(a_code, b_code, faults_); }
  void set_laser(bool on) { laser_.set(on); }
  void start_samples(PsdSample* samples, uint32_t count) { sampler_.start(samples, count, faults_); }
  uint64_t step_clock() const { return steps_.now(); }
  bool schedule_step(Axis axis, uint64_t tick, int direction) {
    return steps_.schedule(axis, tick, direction);
  }
  bool cancel_step(Axis axis) { return steps_.cancel(axis); }
  uint32_t inputs() const {
    const uint32_t bits = inputs_.read();
    // What did not come ready makes measuring wrong: no light, and FAULT_LASER besides the log line that says
    // why.
    return faults_.measuring_is_off() ? bits & ~Inputs::kLaserGood : bits;
  }
  size_t read(uint8_t* bytes, size_t capacity) {
    watchdog_.line_read();
    return line_.read(bytes, capacity);
  }
  size_t write(const uint8_t* bytes, size_t count) { return line_.write(bytes, count); }
  void mask_interrupts(bool on) { Bus::hold_back(on ? kStepPriority : 0); }
  void kick_watchdog() {
    laser_.loop_turned();
    watchdog_.kick();
  }
  Storage& storage() { return storage_; }
  tg_ResetCause reset_cause() const { return reset_cause_; }
  void restart(bool into_bootloader) { start_.restart(into_bootloader); }
  uint32_t stack_free_bytes() const { return start_.stack_free_bytes(); }
  bool self_check(tg_SelfTestCheck check, tg_SelfTestItem* item) {
    if (check == tg_SelfTestCheck_CHECK_CLOCK) {
      const bool right = clock_check_.known() && clock_check_.off_ppm() <= ClockCheck::kMostPpm &&
                         !faults_.has(WaitFault::kCrystal) && !faults_.has(WaitFault::kClockSwitch);
      item->result = right ? tg_SelfTestResult_SELF_TEST_PASSED : tg_SelfTestResult_SELF_TEST_FAILED;
      item->value = clock_check_.off_ppm();
      item->limit = ClockCheck::kMostPpm;
      return true;
    }
    if (check != tg_SelfTestCheck_CHECK_TRANSPORT) return false;
    item->result = line_.by_dma() ? tg_SelfTestResult_SELF_TEST_PASSED : tg_SelfTestResult_SELF_TEST_FAILED;
    item->value = line_.by_dma();
    item->limit = 1;
    return true;
  }

  // ---------------------------------------------------------------- for the interrupts

  const WaitFaults& faults() const { return faults_; }
  SerialLine<Bus>& line() { return line_; }
  StepTimer<Bus>& steps() { return steps_; }
  AlarmClock<Bus>& clock() { return clock_; }
  InputPins<Bus>& input_pins() { return inputs_; }
  bool on_samples_dma() { return sampler_.on_dma_interrupt(faults_); }

  // Every millisecond.
  void on_tick() {
    laser_.on_tick();
    watchdog_.on_tick(line_.sent(), line_.waiting());
    clock_check_.on_tick(static_cast<uint32_t>(steps_.now()));
    show_light();
  }

 private:
  // 16 words by DMA take some 100 cycles.
  static constexpr uint32_t kDmaTurns = 10'000;

  // Steady when all is well; else as many flashes as the number of the first fault, and a pause.
  void show_light() {
    ++light_ms_;
    uint32_t first = 0;
    while (first < kWaitFaults && !faults_.has(static_cast<WaitFault>(first))) ++first;
    if (first == kWaitFaults) return pins::Light::set<Bus>(false);
    constexpr uint32_t kFlashMs = 300, kPauseMs = 1500;
    const uint32_t at = light_ms_ % ((first + 1) * kFlashMs + kPauseMs);
    const bool on = at < (first + 1) * kFlashMs && at % kFlashMs < kFlashMs / 2;
    pins::Light::set<Bus>(!on);
  }

  StartInfo start_;
  WaitFaults faults_;
  LaserSwitch<Bus> laser_;
  SerialLine<Bus> line_;
  AlarmClock<Bus> clock_;
  StepTimer<Bus> steps_;
  Mirrors<Bus> mirrors_;
  Sampler<Bus> sampler_;
  InputPins<Bus> inputs_;
  FlashStorage<Bus> storage_;
  Watchdog<Bus> watchdog_;
  ClockCheck clock_check_;
  tg_ResetCause reset_cause_ = tg_ResetCause_RESET_UNKNOWN;
  uint32_t boot_id_ = 0;
  uint32_t light_ms_ = 0;
};

}  // namespace tetragauge
