// SPDX-License-Identifier: Apache-2.0
#include "protocol/frame.hpp"

#include <array>
#include <cstring>

namespace tetragauge {
namespace {

constexpr std::array<uint32_t, 256> crc32c_table() {
  std::array<uint32_t, 256> table{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0x82F63B78u : 0u);
    table[i] = crc;
  }
  return table;
}
constexpr auto kCrcTable = crc32c_table();

void put_u32(uint8_t* out, uint32_t value) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<uint8_t>(value >> (8 * i));
}

uint32_t get_u32(const uint8_t* in) {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= static_cast<uint32_t>(in[i]) << (8 * i);
  return value;
}

}  // namespace

uint32_t crc32c(const void* data, size_t bytes, uint32_t crc) {
  const auto* byte = static_cast<const uint8_t*>(data);
  crc = ~crc;
  for (size_t i = 0; i < bytes; ++i) crc = (crc >> 8) ^ kCrcTable[(crc ^ byte[i]) & 0xFFu];
  return ~crc;
}

size_t cobs_encode(const uint8_t* data, size_t bytes, uint8_t* out) {
  size_t code_at = 0;  // where the current block's length byte goes
  size_t write = 1;
  uint8_t code = 1;
  for (size_t i = 0; i < bytes; ++i) {
    if (data[i] != 0) {
      out[write++] = data[i];
      ++code;
    }
    const bool full = code == 0xFF;
    // A full block stands for no zero; it is closed only if something follows it.
    if (data[i] == 0 || (full && i + 1 < bytes)) {
      out[code_at] = code;
      code_at = write++;
      code = 1;
    }
  }
  out[code_at] = code;
  return write;
}

bool cobs_decode(const uint8_t* data, size_t bytes, uint8_t* out, size_t capacity, size_t* out_bytes) {
  size_t write = 0;
  size_t read = 0;
  if (bytes == 0) return false;
  while (read < bytes) {
    const uint8_t code = data[read++];
    if (code == 0 || read + (code - 1u) > bytes) return false;
    if (write + (code - 1u) > capacity) return false;
    for (uint8_t i = 1; i < code; ++i) {
      if (data[read] == 0) return false;
      out[write++] = data[read++];
    }
    if (code != 0xFF && read < bytes) {
      if (write == capacity) return false;
      out[write++] = 0;
    }
  }
  *out_bytes = write;
  return true;
}

size_t encode_frame(FrameHeader header, const uint8_t* payload, size_t payload_bytes, uint8_t* wire) {
  if (payload_bytes > kFramePayloadBytes) return 0;
  uint8_t decoded[kFrameDecodedBytes];
  decoded[0] = static_cast<uint8_t>(header.channel);
  put_u32(decoded + 1, header.id);
  if (payload_bytes > 0) std::memcpy(decoded + kFrameHeaderBytes, payload, payload_bytes);
  const size_t body = kFrameHeaderBytes + payload_bytes;
  put_u32(decoded + body, crc32c(decoded, body));
  const size_t length = cobs_encode(decoded, body + kFrameCrcBytes, wire);
  wire[length] = 0;
  return length + 1;
}

bool FrameReader::push(uint8_t byte) {
  if (byte != 0) {
    if (wire_bytes_ < sizeof wire_) {
      wire_[wire_bytes_++] = byte;
    } else {
      too_long_ = true;
    }
    return false;
  }
  const bool empty = wire_bytes_ == 0;  // 00 00: a resynchronising host, not an error
  const bool good = !empty && !too_long_ && decode();
  if (!good && !empty) ++bad_frames_;
  wire_bytes_ = 0;
  too_long_ = false;
  return good;
}

bool FrameReader::decode() {
  size_t bytes = 0;
  if (!cobs_decode(wire_, wire_bytes_, decoded_, sizeof decoded_, &bytes)) return false;
  if (bytes < kFrameHeaderBytes + kFrameCrcBytes) return false;
  const size_t body = bytes - kFrameCrcBytes;
  if (get_u32(decoded_ + body) != crc32c(decoded_, body)) return false;
  if (decoded_[0] < static_cast<uint8_t>(Channel::kRequest) ||
      decoded_[0] > static_cast<uint8_t>(Channel::kStream)) {
    return false;
  }
  frame_.header = {static_cast<Channel>(decoded_[0]), get_u32(decoded_ + 1)};
  frame_.payload = decoded_ + kFrameHeaderBytes;
  frame_.payload_bytes = body - kFrameHeaderBytes;
  return true;
}

}  // namespace tetragauge
