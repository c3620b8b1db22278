// SPDX-License-Identifier: Apache-2.0
// What the simulated world and the firmware's image say to each other, in turn, each over a FIFO of its own:
//
//   world: WorldSays [samples or bytes of the host]     something has come, at that virtual time
//   image: ImageSays [actions] [payload]                what the firmware did; it has finished, or it asks
//   world: WorldSays (answer) [words]                   ... until it has finished
//
// The world has the time: it stands still while the image works. One exchange for each thing that comes (a
// timer, a window of samples), unless the firmware asks for something that the world alone knows. Both sides
// are little-endian and keep 64-bit numbers on 8 bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace tetragauge::mps2_bus {

static_assert(std::endian::native == std::endian::little);

// In the folder that the image's emulator runs in.
inline constexpr const char* kToImage = "to_image";
inline constexpr const char* kToWorld = "to_world";

// Both sides must mean the same by a burst and a step.
inline constexpr uint32_t kSamplePeriodNs = 30'000;
inline constexpr uint32_t kStepTicksPerSecond = 1'000'000'000;
inline constexpr int32_t kMirrorCodeStep = 1;

inline constexpr size_t kMostLineBytes = 520;   // of the host, in one turn: a frame
inline constexpr size_t kMostStoreWords = 128;  // in one question
inline constexpr size_t kMostActions = 32;      // in one message of the image

enum class Call : uint8_t { start, table_step, slide_step, interlock, alarm, samples, poll, line, answer };

struct WorldSays {
  Call call = Call::poll;
  uint8_t store_busy = 0;
  uint16_t samples = 0;     // PsdSample, of Call::samples
  uint32_t line_bytes = 0;  // of the host, of Call::line
  uint64_t now_ns = 0;
  uint32_t inputs = 0;  // Inputs::k...
  // start: boot id, reset cause, words of a bank. answer: what the question says.
  uint32_t values[3] = {};
};
static_assert(sizeof(WorldSays) == 32);

enum class Question : uint8_t {
  none,         // finished
  inputs,       // -
  line_write,   // payload: bytes; answer: how many were taken
  store_erase,  // bank; answer: 1 it is done or started, 0 failed
  store_write,  // bank, first word, count, payload: words; answer: the same
  store_read,   // bank, first word, count; the answer is followed by the words
};

struct ImageSays {
  Question question = Question::none;
  uint8_t resting = 0;
  uint16_t actions = 0;        // Action each, to be done before anything else
  uint32_t payload_bytes = 0;  // after the actions
  uint32_t values[3] = {};     // of the question
  uint32_t state = 0, fault = 0, view = 0;
  uint64_t next_poll_ns = 0;
  uint64_t ticks = 0;  // of the processor's time since the turn began, kTickNs each
};
static_assert(sizeof(ImageSays) == 48);

// The board's timer counts at 25 MHz; at QEMU's `-icount shift=3` an instruction takes 8 ns of it.
inline constexpr uint32_t kTickNs = 40;
inline constexpr uint32_t kInstructionNs = 8;

struct Action {
  enum class What : uint8_t { alarm, mirrors, laser, samples, step, cancel_step, restart };
  What what = What::alarm;
  uint8_t axis = 0;
  int16_t a = 0,
          b = 0;       // mirrors: codes; laser, restart: a = 0 or 1; samples: a = count; step: a = direction
  uint16_t zero = 0;   // keeps the next one on 8 bytes
  uint64_t value = 0;  // alarm: ns; step: tick
};
static_assert(sizeof(Action) == 16);

}  // namespace tetragauge::mps2_bus
