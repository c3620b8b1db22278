// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an386/qemu_firmware.hpp"

#include <algorithm>
#include <cstring>

namespace tetragauge {
namespace {

using mps2_bus::Action;
using mps2_bus::Call;
using mps2_bus::ImageSays;
using mps2_bus::Question;
using mps2_bus::WorldSays;

static_assert(mps2_bus::kSamplePeriodNs == EmulatedBoard::kSamplePeriodNs &&
              mps2_bus::kMirrorCodeStep == EmulatedBoard::kMirrorCodeStep &&
              mps2_bus::kStepTicksPerSecond == EmulatedBoard::kStepTicksPerSecond);

Call call_of(EmulatedBoard::Event event) {
  switch (event) {
    case EmulatedBoard::Event::table_step:
      return Call::table_step;
    case EmulatedBoard::Event::slide_step:
      return Call::slide_step;
    case EmulatedBoard::Event::interlock:
      return Call::interlock;
    case EmulatedBoard::Event::alarm:
      return Call::alarm;
    case EmulatedBoard::Event::samples:
      return Call::samples;
    case EmulatedBoard::Event::none:
      break;
  }
  return Call::poll;
}

Error nonsense() {
  return machine_error(
      "--board mps2_an386: the image does not speak this program's language; run script/build, which makes "
      "both");
}

}  // namespace

// A frame of the host at a time: how the image's work is parted does not depend on how the operating system
// parts the host's bytes. What has no end yet waits for it.
std::vector<uint8_t> QemuFirmware::next_of_line() {
  const auto end = std::find(line_.begin(), line_.end(), uint8_t{0});
  size_t count = static_cast<size_t>(end - line_.begin()) + (end != line_.end() ? 1 : 0);
  if (end == line_.end() && count < mps2_bus::kMostLineBytes) count = 0;
  count = std::min(count, mps2_bus::kMostLineBytes);
  const std::vector<uint8_t> part(line_.begin(), line_.begin() + static_cast<ptrdiff_t>(count));
  line_.erase(line_.begin(), line_.begin() + static_cast<ptrdiff_t>(count));
  return part;
}

Status QemuFirmware::start() {
  line_.clear();
  WorldSays says;
  says.call = Call::start;
  says.values[0] = board_.boot_id();
  says.values[1] = static_cast<uint32_t>(board_.reset_cause());
  says.values[2] = store_.bank_words();
  return turn(says, nullptr, 0);
}

Status QemuFirmware::run(EmulatedBoard::Event event) {
  WorldSays says;
  says.call = call_of(event);
  if (event == EmulatedBoard::Event::samples) says.samples = static_cast<uint16_t>(burst_count_);
  if (const Status done = turn(says, burst_.data(), says.samples * sizeof(PsdSample)); !done) return done;
  return take_bytes();
}

Status QemuFirmware::take_bytes() {
  uint8_t bytes[256];
  while (const size_t count = board_.read(bytes, sizeof bytes))
    line_.insert(line_.end(), bytes, bytes + count);
  for (;;) {
    const std::vector<uint8_t> part = next_of_line();
    if (part.empty()) return Done{};
    WorldSays says;
    says.call = Call::line;
    says.line_bytes = static_cast<uint32_t>(part.size());
    if (const Status done = turn(says, part.data(), part.size()); !done) return done;
  }
}

Trace::Seen QemuFirmware::seen() const {
  return {static_cast<tg_State>(last_.state), static_cast<tg_FaultCode>(last_.fault), last_.view + 1};
}

Status QemuFirmware::say(WorldSays says, const void* payload, size_t payload_bytes) {
  says.now_ns = board_.now_ns();
  says.inputs = board_.inputs();
  says.store_busy = store_.busy();
  uint8_t message[sizeof says + sizeof burst_ + mps2_bus::kMostLineBytes];
  std::memcpy(message, &says, sizeof says);
  if (payload_bytes > 0) std::memcpy(message + sizeof says, payload, payload_bytes);
  return qemu_->send(message, sizeof says + payload_bytes);
}

Status QemuFirmware::turn(const WorldSays& says, const void* payload, size_t payload_bytes) {
  if (const Status said = say(says, payload, payload_bytes); !said) return said;
  for (;;) {
    ImageSays heard;
    if (const Status got = qemu_->receive(&heard, sizeof heard); !got) return got;
    if (const Status done = do_actions(heard.actions); !done) return done;
    if (heard.question == Question::none) {
      if (heard.state >= work_.size() || heard.fault >= _tg_FaultCode_ARRAYSIZE) return nonsense();
      Work& work = work_[last_.state][static_cast<size_t>(says.call)];
      ++work.turns;
      work.ticks += heard.ticks;
      last_ = heard;
      return Done{};
    }
    if (const Status done = answer(heard); !done) return done;
  }
}

Status QemuFirmware::do_actions(size_t count) {
  std::array<Action, mps2_bus::kMostActions> actions;
  if (count > actions.size()) return nonsense();
  if (const Status got = qemu_->receive(actions.data(), count * sizeof(Action)); !got) return got;
  for (size_t k = 0; k < count; ++k) {
    const Action& action = actions[k];
    const Axis axis = action.axis == 0 ? Axis::kTable : Axis::kSlide;
    switch (action.what) {
      case Action::What::alarm:
        board_.set_alarm_ns(action.value);
        break;
      case Action::What::mirrors:
        board_.set_mirrors(action.a, action.b);
        break;
      case Action::What::laser:
        board_.set_laser(action.a != 0);
        break;
      case Action::What::samples:
        burst_count_ = static_cast<size_t>(action.a);
        if (burst_count_ > burst_.size()) return nonsense();
        board_.start_samples(burst_.data(), static_cast<uint32_t>(burst_count_));
        break;
      case Action::What::step:
        board_.schedule_step(axis, action.value, action.a);
        break;
      case Action::What::cancel_step:
        board_.cancel_step(axis);
        break;
      case Action::What::restart:
        board_.restart(action.a != 0);
        break;
      default:
        return nonsense();
    }
  }
  return Done{};
}

Status QemuFirmware::answer(const ImageSays& question) {
  std::vector<uint8_t> payload(std::min<size_t>(question.payload_bytes, 4096));
  if (payload.size() != question.payload_bytes) return nonsense();
  if (const Status got = qemu_->receive(payload.data(), payload.size()); !got) return got;
  WorldSays says;
  says.call = Call::answer;
  std::array<uint32_t, mps2_bus::kMostStoreWords> words{};
  size_t words_back = 0;
  const auto [bank, first_word, count] = std::to_array(question.values);
  const bool in_store = bank < Storage::kBanks && count <= words.size() &&
                        first_word <= store_.bank_words() && count <= store_.bank_words() - first_word;
  switch (question.question) {
    case Question::inputs:
      break;
    case Question::line_write:
      says.values[0] = static_cast<uint32_t>(board_.write(payload.data(), payload.size()));
      break;
    case Question::store_erase:
      if (bank >= Storage::kBanks) return nonsense();
      says.values[0] = store_.erase(bank);
      break;
    case Question::store_write:
      if (!in_store || payload.size() != count * sizeof(uint32_t)) return nonsense();
      std::memcpy(words.data(), payload.data(), payload.size());
      says.values[0] = store_.write(bank, first_word, words.data(), count);
      break;
    case Question::store_read:
      if (!in_store) return nonsense();
      store_.read(bank, first_word, words.data(), count);
      words_back = count;
      break;
    default:
      return nonsense();
  }
  return say(says, words.data(), words_back * sizeof(uint32_t));
}

}  // namespace tetragauge
