// SPDX-License-Identifier: Apache-2.0
// Up to three bits wrong in a frame: it must not be accepted, and nothing else in its place. CRC-32C alone
// has Hamming distance 6 at these lengths, but COBS lets a bit do more: one that becomes 00 splits the frame,
// one in the final 00 joins it to the next, one in a length byte moves the zeros of the data.
#include <gtest/gtest.h>

#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "protocol/frame.hpp"
#include "protocol/golden_frames.hpp"

namespace tetragauge {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes wire_of(const GoldenFrame& golden) {
  Bytes bytes;
  for (const char* hex = golden.hex; *hex != '\0'; hex += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(std::string(hex, 2), nullptr, 16)));
  }
  return bytes;
}

// Flips bits of a frame that has another one behind it.
class Line {
 public:
  explicit Line(const Bytes& frame) : frame_(frame), follower_(wire_of(kGoldenFrames[0])) {
    FrameReader reader;
    for (uint8_t byte : follower_) {
      if (reader.push(byte)) follower_payload_.assign(reader.frame().payload, end_of(reader.frame()));
    }
  }
  size_t bits() const { return frame_.size() * 8; }
  void flip(size_t bit) { frame_[bit / 8] = static_cast<uint8_t>(frame_[bit / 8] ^ (1u << (bit % 8))); }

  // Nothing is accepted but the frame behind, and that one unless the last 00 is gone.
  bool spoiled_frame_is_rejected() const {
    FrameReader reader;
    for (uint8_t byte : frame_) {
      if (reader.push(byte)) return false;
    }
    int followers = 0;
    for (uint8_t byte : follower_) {
      if (!reader.push(byte)) continue;
      if (Bytes(reader.frame().payload, end_of(reader.frame())) != follower_payload_) return false;
      ++followers;
    }
    return followers == (frame_.back() == 0 ? 1 : 0);
  }

 private:
  static const uint8_t* end_of(const Frame& frame) { return frame.payload + frame.payload_bytes; }
  Bytes frame_;
  const Bytes follower_;
  Bytes follower_payload_;
};

constexpr size_t kShort = 24;   // bytes; all triples of a frame's bits are tried up to here
constexpr size_t kMiddle = 64;  // all pairs

TEST(FrameErrors, OneBitAnywhere) {
  for (const GoldenFrame& golden : kGoldenFrames) {
    Line line(wire_of(golden));
    for (size_t i = 0; i < line.bits(); ++i) {
      line.flip(i);
      ASSERT_TRUE(line.spoiled_frame_is_rejected()) << golden.name << ", bit " << i;
      line.flip(i);
    }
  }
}

TEST(FrameErrors, EveryTwoBitsOfMostFrames) {
  for (const GoldenFrame& golden : kGoldenFrames) {
    Line line(wire_of(golden));
    if (line.bits() > kMiddle * 8) continue;
    for (size_t i = 0; i < line.bits(); ++i) {
      line.flip(i);
      for (size_t j = i + 1; j < line.bits(); ++j) {
        line.flip(j);
        ASSERT_TRUE(line.spoiled_frame_is_rejected()) << golden.name << ", bits " << i << ", " << j;
        line.flip(j);
      }
      line.flip(i);
    }
  }
}

TEST(FrameErrors, EveryThreeBitsOfShortFrames) {
  uint64_t tried = 0;
  for (const GoldenFrame& golden : kGoldenFrames) {
    Line line(wire_of(golden));
    if (line.bits() > kShort * 8) continue;
    for (size_t i = 0; i < line.bits(); ++i) {
      line.flip(i);
      for (size_t j = i + 1; j < line.bits(); ++j) {
        line.flip(j);
        for (size_t k = j + 1; k < line.bits(); ++k) {
          line.flip(k);
          ASSERT_TRUE(line.spoiled_frame_is_rejected())
              << golden.name << ", bits " << i << ", " << j << ", " << k;
          line.flip(k);
          ++tried;
        }
        line.flip(j);
      }
      line.flip(i);
    }
  }
  std::printf("%llu triples of bits, all rejected\n", static_cast<unsigned long long>(tried));
}

TEST(FrameErrors, ThreeBitsOfLongFramesSampled) {
  std::mt19937 random(20261122);
  for (const GoldenFrame& golden : kGoldenFrames) {
    Line line(wire_of(golden));
    if (line.bits() <= kShort * 8) continue;
    for (int trial = 0; trial < 50'000; ++trial) {
      size_t bit[3];
      do {
        for (size_t& b : bit) b = random() % line.bits();
      } while (bit[0] == bit[1] || bit[1] == bit[2] || bit[0] == bit[2]);
      for (size_t b : bit) line.flip(b);
      ASSERT_TRUE(line.spoiled_frame_is_rejected())
          << golden.name << ", bits " << bit[0] << ", " << bit[1] << ", " << bit[2];
      for (size_t b : bit) line.flip(b);
    }
  }
}

}  // namespace
}  // namespace tetragauge
