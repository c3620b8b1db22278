// SPDX-License-Identifier: Apache-2.0
#include "protocol/frame.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

namespace tetragauge {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes range(int first, int last) {
  Bytes bytes;
  for (int i = first; i <= last; ++i) bytes.push_back(static_cast<uint8_t>(i));
  return bytes;
}

Bytes joined(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Bytes cobs(const Bytes& data) {
  Bytes out(data.size() + data.size() / 254 + 1);
  out.resize(cobs_encode(data.data(), data.size(), out.data()));
  return out;
}

bool uncobs(const Bytes& data, Bytes* out, size_t capacity = 2048) {
  out->resize(capacity);
  size_t bytes = 0;
  if (!cobs_decode(data.data(), data.size(), out->data(), capacity, &bytes)) return false;
  out->resize(bytes);
  return true;
}

// Written from the definition instead of the algorithm: split at every zero of data + 0, then each piece into
// runs of 254.
Bytes cobs_by_definition(const Bytes& data) {
  Bytes out, piece;
  const auto close = [&](bool last) {
    size_t at = 0;
    while (piece.size() - at >= 254 && !(last && piece.size() - at == 254)) {
      out.push_back(255);
      out.insert(out.end(), piece.begin() + static_cast<long>(at),
                 piece.begin() + static_cast<long>(at) + 254);
      at += 254;
    }
    out.push_back(static_cast<uint8_t>(piece.size() - at + 1));
    out.insert(out.end(), piece.begin() + static_cast<long>(at), piece.end());
    piece.clear();
  };
  for (uint8_t byte : data) {
    if (byte == 0)
      close(false);
    else
      piece.push_back(byte);
  }
  close(true);
  return out;
}

// Bit by bit, most significant first on the reflected data: another way than the table.
uint32_t crc_bit_by_bit(const Bytes& data) {
  uint32_t crc = 0xFFFFFFFFu;
  for (uint8_t byte : data) {
    for (int bit = 0; bit < 8; ++bit) {
      const uint32_t in = (byte >> bit) & 1u;
      const uint32_t out = (crc >> 31) & 1u;
      crc = (crc << 1) ^ (in != out ? 0x1EDC6F41u : 0u);
    }
  }
  crc = ~crc;
  uint32_t reversed = 0;
  for (int bit = 0; bit < 32; ++bit) reversed |= ((crc >> bit) & 1u) << (31 - bit);
  return reversed;
}

TEST(Crc32c, PublishedVectors) {
  EXPECT_EQ(crc32c("123456789", 9), 0xE3069283u);
  // RFC 3720, appendix B.4; the RFC prints the bytes in the order they go out.
  EXPECT_EQ(crc32c(Bytes(32, 0x00).data(), 32), 0x8A9136AAu);
  EXPECT_EQ(crc32c(Bytes(32, 0xFF).data(), 32), 0x62A8AB43u);
  EXPECT_EQ(crc32c(range(0, 31).data(), 32), 0x46DD794Eu);
  Bytes down = range(0, 31);
  std::reverse(down.begin(), down.end());
  EXPECT_EQ(crc32c(down.data(), 32), 0x113FDB5Cu);
}

TEST(Crc32c, AgreesWithTheDefinitionAndContinues) {
  std::mt19937 random(1);
  for (size_t size = 0; size < 300; ++size) {
    Bytes data(size);
    for (uint8_t& byte : data) byte = static_cast<uint8_t>(random());
    EXPECT_EQ(crc32c(data.data(), size), crc_bit_by_bit(data));
    const size_t cut = size / 3;
    EXPECT_EQ(crc32c(data.data() + cut, size - cut, crc32c(data.data(), cut)), crc32c(data.data(), size));
  }
}

TEST(Cobs, ExamplesOfTheLiterature) {
  // The examples of the Wikipedia article on COBS, without the ending 00.
  const std::pair<Bytes, Bytes> examples[] = {
      {{0x00}, {0x01, 0x01}},
      {{0x00, 0x00}, {0x01, 0x01, 0x01}},
      {{0x00, 0x11, 0x00}, {0x01, 0x02, 0x11, 0x01}},
      {{0x11, 0x22, 0x00, 0x33}, {0x03, 0x11, 0x22, 0x02, 0x33}},
      {{0x11, 0x22, 0x33, 0x44}, {0x05, 0x11, 0x22, 0x33, 0x44}},
      {{0x11, 0x00, 0x00, 0x00}, {0x02, 0x11, 0x01, 0x01, 0x01}},
      {range(1, 254), joined({0xFF}, range(1, 254))},
      {joined({0}, range(1, 254)), joined({0x01, 0xFF}, range(1, 254))},
      {range(1, 255), joined(joined({0xFF}, range(1, 254)), {0x02, 0xFF})},
      {joined(range(2, 255), {0}), joined(joined({0xFF}, range(2, 255)), {0x01, 0x01})},
      {joined(range(3, 255), {0, 1}), joined(joined({0xFE}, range(3, 255)), {0x02, 0x01})},
  };
  for (const auto& [data, code] : examples) {
    EXPECT_EQ(cobs(data), code);
    Bytes back;
    ASSERT_TRUE(uncobs(code, &back));
    EXPECT_EQ(back, data);
  }
}

TEST(Cobs, EveryShortStringAndManyLongOnes) {
  // Every string of up to 7 bytes over {0, 1, 255}.
  for (int size = 0; size <= 7; ++size) {
    int count = 1;
    for (int i = 0; i < size; ++i) count *= 3;
    for (int code = 0; code < count; ++code) {
      Bytes data;
      for (int i = 0, rest = code; i < size; ++i, rest /= 3)
        data.push_back(static_cast<uint8_t>("\x00\x01\xFF"[rest % 3]));
      Bytes back;
      ASSERT_EQ(cobs(data), cobs_by_definition(data));
      ASSERT_TRUE(uncobs(cobs(data), &back));
      ASSERT_EQ(back, data);
    }
  }
  std::mt19937 engine(2);
  const auto random = [&engine] { return static_cast<uint32_t>(engine()); };
  for (int trial = 0; trial < 3000; ++trial) {
    Bytes data(random() % 1100);
    const uint32_t zero_every = 1 + random() % 400;
    for (uint8_t& byte : data)
      byte = random() % zero_every == 0 ? uint8_t{0} : static_cast<uint8_t>(1 + random() % 255);
    const Bytes code = cobs(data);
    ASSERT_EQ(code, cobs_by_definition(data));
    ASSERT_EQ(std::count(code.begin(), code.end(), 0), 0);
    Bytes back;
    ASSERT_TRUE(uncobs(code, &back));
    ASSERT_EQ(back, data);
  }
}

TEST(Cobs, RefusesWhatNoEncoderMakesAndStaysInBounds) {
  Bytes back;
  EXPECT_FALSE(uncobs({}, &back));
  EXPECT_FALSE(uncobs({0x05, 0x11, 0x22}, &back)) << "block longer than the frame";
  EXPECT_FALSE(uncobs({0x03, 0x11, 0x00}, &back)) << "zero inside";
  EXPECT_FALSE(uncobs({0x01, 0x01, 0x01}, &back, 1)) << "two bytes into one";
  EXPECT_FALSE(uncobs({0x04, 1, 2, 3}, &back, 2));
  EXPECT_TRUE(uncobs({0x04, 1, 2, 3}, &back, 3));
}

Bytes frame_of(const Bytes& payload, FrameHeader header = {Channel::kRequest, 0x01020304}) {
  Bytes wire(kFrameWireBytes);
  wire.resize(encode_frame(header, payload.data(), payload.size(), wire.data()));
  return wire;
}

TEST(Frame, BytesOnTheWire) {
  // channel 1, id 01020304, payload 0A 00, CRC-32C of those 7 bytes computed bit by bit, COBS by hand.
  const Bytes body = {0x01, 0x04, 0x03, 0x02, 0x01, 0x0A, 0x00};
  const uint32_t crc = crc_bit_by_bit(body);
  Bytes expected = {0x07, 0x01, 0x04, 0x03, 0x02, 0x01, 0x0A, 0x05};
  for (int i = 0; i < 4; ++i) expected.push_back(static_cast<uint8_t>(crc >> (8 * i)));
  expected.push_back(0x00);
  EXPECT_EQ(frame_of({0x0A, 0x00}), expected);
}

TEST(FrameReader, TakesEveryPayloadSize) {
  FrameReader reader;
  std::mt19937 random(3);
  for (size_t size = 0; size <= kFramePayloadBytes; ++size) {
    Bytes payload(size);
    for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random() % 4);
    const Bytes wire = frame_of(payload, {Channel::kStream, static_cast<uint32_t>(size)});
    ASSERT_LE(wire.size(), kFrameWireBytes);
    for (size_t i = 0; i + 1 < wire.size(); ++i) ASSERT_FALSE(reader.push(wire[i]));
    ASSERT_TRUE(reader.push(wire.back()));
    EXPECT_EQ(reader.frame().header.id, size);
    EXPECT_EQ(reader.frame().header.channel, Channel::kStream);
    EXPECT_EQ(Bytes(reader.frame().payload, reader.frame().payload + reader.frame().payload_bytes), payload);
  }
  EXPECT_EQ(reader.bad_frames(), 0u);
  uint8_t wire[kFrameWireBytes];
  EXPECT_EQ(encode_frame({}, Bytes(600).data(), kFramePayloadBytes + 1, wire), 0u);
}

int frames_in(FrameReader& reader, const Bytes& bytes) {
  int frames = 0;
  for (uint8_t byte : bytes) frames += reader.push(byte) ? 1 : 0;
  return frames;
}

TEST(FrameReader, OneZeroResynchronises) {
  const Bytes good = frame_of({1, 2, 3});
  FrameReader reader;
  // Joined the line in the middle of a frame.
  EXPECT_EQ(frames_in(reader, Bytes(good.begin() + 4, good.end())), 0);
  EXPECT_EQ(frames_in(reader, good), 1);
  EXPECT_EQ(reader.bad_frames(), 1u);
  // A lost end swallows the next frame only.
  EXPECT_EQ(frames_in(reader, Bytes(good.begin(), good.end() - 1)), 0);
  EXPECT_EQ(frames_in(reader, good), 0);
  EXPECT_EQ(frames_in(reader, good), 1);
  EXPECT_EQ(reader.bad_frames(), 2u);
  // Far too much without an end, of bytes that are COBS.
  EXPECT_EQ(frames_in(reader, Bytes(5000, 0x01)), 0);
  EXPECT_EQ(frames_in(reader, {0x00}), 0);
  EXPECT_EQ(frames_in(reader, good), 1);
  EXPECT_EQ(reader.bad_frames(), 3u);
  // Zeros between frames are no frames.
  EXPECT_EQ(frames_in(reader, {0, 0, 0}), 0);
  EXPECT_EQ(reader.bad_frames(), 3u);
}

// CRC-32C detects every error of up to 5 bits in frames this short, but a flipped bit before COBS is decoded
// may move the block boundaries: so try them.

}  // namespace
}  // namespace tetragauge
