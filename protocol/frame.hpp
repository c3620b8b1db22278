// SPDX-License-Identifier: Apache-2.0
// Frames on the wire: COBS( channel u8 | id u32 | protobuf | CRC-32C u32 ) 00, little-endian, at most 512
// bytes before COBS. A bad frame is counted and dropped; one 00 resynchronises.
//
//   uint8_t wire[kFrameWireBytes];
//   size_t n = encode_frame({Channel::kRequest, id}, payload, size, wire);
//
//   FrameReader reader;
//   for (uint8_t byte : received)
//     if (reader.push(byte)) use(reader.frame());
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetragauge {

inline constexpr uint32_t kProtocolVersion = 1;

inline constexpr size_t kFrameDecodedBytes = 512;  // header, payload and CRC
inline constexpr size_t kFrameHeaderBytes = 5;
inline constexpr size_t kFrameCrcBytes = 4;
inline constexpr size_t kFramePayloadBytes = kFrameDecodedBytes - kFrameHeaderBytes - kFrameCrcBytes;
// COBS adds one byte and one more for every 254 (Cheshire and Baker 1999, section 3), and the 00 ends it.
inline constexpr size_t kFrameWireBytes = kFrameDecodedBytes + kFrameDecodedBytes / 254 + 2;

enum class Channel : uint8_t {
  kRequest = 1,  // host to machine; id is the request's, the reply carries it back
  kReply = 2,
  kEvent = 3,   // either way, no reply, may be lost: heartbeat, credit, resend, fault, log; id counts them
  kStream = 4,  // machine to host: point batches and scan end; id is the item's number within the scan
};

struct FrameHeader {
  Channel channel = Channel::kRequest;
  uint32_t id = 0;
};

struct Frame {
  FrameHeader header;
  const uint8_t* payload = nullptr;
  size_t payload_bytes = 0;
};

// CRC-32C (Castagnoli, reflected polynomial 82F63B78, initial value and final xor FFFFFFFF; RFC 3720 appendix
// B.4). Continues from `crc`, the value of the bytes before; 0 to start.
uint32_t crc32c(const void* data, size_t bytes, uint32_t crc = 0);

// COBS without the ending 00; `out` must hold bytes + bytes / 254 + 1. Returns the bytes written.
size_t cobs_encode(const uint8_t* data, size_t bytes, uint8_t* out);
// Inverse, `data` without the 00; at most `capacity` bytes out. Returns false for what no encoder makes.
bool cobs_decode(const uint8_t* data, size_t bytes, uint8_t* out, size_t capacity, size_t* out_bytes);

// Writes the whole frame with its ending 00 into `wire` (kFrameWireBytes) and returns its length; 0 when the
// payload is longer than kFramePayloadBytes.
size_t encode_frame(FrameHeader header, const uint8_t* payload, size_t payload_bytes, uint8_t* wire);

class FrameReader {
 public:
  // True when this byte ended a good frame; frame() then is valid until the next push.
  bool push(uint8_t byte);
  const Frame& frame() const { return frame_; }
  uint32_t bad_frames() const { return bad_frames_; }

 private:
  bool decode();

  uint8_t wire_[kFrameWireBytes] = {};
  uint8_t decoded_[kFrameDecodedBytes] = {};
  size_t wire_bytes_ = 0;
  bool too_long_ = false;
  uint32_t bad_frames_ = 0;
  Frame frame_;
};

}  // namespace tetragauge
