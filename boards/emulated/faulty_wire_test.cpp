// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/faulty_wire.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tetragauge {
namespace {

constexpr int kBytes = 100'000;

// What comes out of a wire into which the bytes 1, 2, ... 250, 1, ... go, one a microsecond.
std::vector<uint8_t> sent_through(FaultyWire wire, uint64_t until_ns) {
  std::vector<uint8_t> out;
  for (int k = 0; k < kBytes; ++k)
    wire.send(static_cast<uint8_t>(k % 250 + 1), static_cast<uint64_t>(k) * 1000);
  while (const auto arrival = wire.take(until_ns)) {
    if (arrival->byte) out.push_back(*arrival->byte);
  }
  return out;
}

constexpr uint64_t kEnd_ns = uint64_t{kBytes} * 1000 + 1'000'000'000;

TEST(FaultyWire, PassesAllOnWithoutFaults) {
  const auto out = sent_through(FaultyWire({}, {}, 1), kEnd_ns);
  ASSERT_EQ(out.size(), size_t{kBytes});
  for (size_t k = 0; k < out.size(); ++k) ASSERT_EQ(out[k], k % 250 + 1);
}

TEST(FaultyWire, HasItsShareOfFaultsAndRepeatsThem) {
  const double share = 1e-2, spread = 5 * std::sqrt(share * kBytes);
  const auto dropped = sent_through(FaultyWire({.drop = share}, {}, 1), kEnd_ns);
  EXPECT_NEAR(static_cast<double>(kBytes) - static_cast<double>(dropped.size()), share * kBytes, spread);
  EXPECT_EQ(dropped, sent_through(FaultyWire({.drop = share}, {}, 1), kEnd_ns));
  EXPECT_NE(dropped, sent_through(FaultyWire({.drop = share}, {}, 2), kEnd_ns));
  const auto doubled = sent_through(FaultyWire({.duplicate = share}, {}, 1), kEnd_ns);
  EXPECT_NEAR(static_cast<double>(doubled.size()) - kBytes, share * kBytes, spread);
  const auto flipped = sent_through(FaultyWire({.flip = share}, {}, 1), kEnd_ns);
  ASSERT_EQ(flipped.size(), size_t{kBytes});
  int wrong = 0;
  for (size_t k = 0; k < flipped.size(); ++k) wrong += flipped[k] != k % 250 + 1 ? 1 : 0;
  EXPECT_NEAR(wrong, share * kBytes, spread);
}

TEST(FaultyWire, WhatIsHeldBackComesLaterInOrder) {
  FaultyWire wire({.delay = 1, .delay_ns = 5000}, {}, 1);
  wire.send(7, 0);
  wire.send(8, 1000);
  EXPECT_EQ(wire.next_due_ns(), 5000u);
  EXPECT_FALSE(wire.take(4999));
  EXPECT_EQ(wire.take(5000)->byte, 7);
  EXPECT_FALSE(wire.take(5999));
  EXPECT_EQ(wire.take(6000)->byte, 8);
}

TEST(FaultyWire, NothingPassesWhileItIsCut) {
  FaultyWire wire({}, {{1000, 2000}}, 1);
  for (uint64_t t = 0; t < 3000; t += 500) wire.send(static_cast<uint8_t>(t / 500 + 1), t);
  std::vector<uint8_t> out;
  while (const auto arrival = wire.take(10'000)) {
    if (arrival->byte) out.push_back(*arrival->byte);
  }
  EXPECT_EQ(out, (std::vector<uint8_t>{1, 2, 5, 6}));
}

}  // namespace
}  // namespace tetragauge
