// SPDX-License-Identifier: Apache-2.0
// A message as one frame, and back. The two envelopes of machine.proto:
//
//   tg_HostMessage m = tg_HostMessage_init_zero;
//   m.which_body = tg_HostMessage_home_tag;
//   size_t n = encode_message({Channel::kRequest, id}, m, wire);   // wire[kFrameWireBytes]
//   tg_MachineMessage reply;
//   if (reader.push(byte) && decode_message(reader.frame(), &reply)) ...
#pragma once

#include "protocol/frame.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

// Most bytes on the wire of an envelope with a body of so many: its tag and length take 4 at most.
constexpr size_t wire_bytes_of(size_t body_bytes) {
  const size_t decoded = kFrameHeaderBytes + 4 + body_bytes + kFrameCrcBytes;
  return decoded + decoded / 254 + 2;
}

// Bytes of the frame with its ending 00; 0 when the message does not fit a frame.
size_t encode_message(FrameHeader header, const tg_HostMessage& message, uint8_t* wire);
size_t encode_message(FrameHeader header, const tg_MachineMessage& message, uint8_t* wire);

// The protobuf alone, into kFramePayloadBytes; 0 when it does not fit.
size_t encode_payload(const tg_MachineMessage& message, uint8_t* payload);
size_t encode_payload(const tg_Config& part, uint8_t* payload);
static_assert(tg_Config_size <= kFramePayloadBytes - 8, "a part of the configuration fits a frame");

// The record that CalibrationWrite carries in chunks; `record` must hold tg_Calibration_size bytes. 0 when it
// cannot be encoded (an id without its end).
size_t encode_calibration(const tg_Calibration& calibration, uint8_t* record);
bool decode_calibration(const uint8_t* record, size_t bytes, tg_Calibration* calibration);

// False when the payload is not such a message, holds none, or has a value that its enumeration does not
// have.
bool decode_message(const Frame& frame, tg_HostMessage* message);
bool decode_message(const Frame& frame, tg_MachineMessage* message);

}  // namespace tetragauge
