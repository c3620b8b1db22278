// SPDX-License-Identifier: Apache-2.0
#include "protocol/message.hpp"

#include <pb_decode.h>
#include <pb_encode.h>

namespace tetragauge {
namespace {

size_t encode_fields(const pb_msgdesc_t* fields, const void* message, uint8_t* payload,
                     size_t capacity = kFramePayloadBytes) {
  pb_ostream_t stream = pb_ostream_from_buffer(payload, capacity);
  return pb_encode(&stream, fields, message) ? stream.bytes_written : 0;
}

bool decode_fields(const pb_msgdesc_t* fields, const Frame& frame, void* message) {
  pb_istream_t stream = pb_istream_from_buffer(frame.payload, frame.payload_bytes);
  return pb_decode(&stream, fields, message);
}

size_t encode_framed(FrameHeader header, const pb_msgdesc_t* fields, const void* message, uint8_t* wire) {
  uint8_t payload[kFramePayloadBytes];
  const size_t bytes = encode_fields(fields, message, payload);
  return bytes == 0 ? 0 : encode_frame(header, payload, bytes, wire);
}

}  // namespace

size_t encode_message(FrameHeader header, const tg_HostMessage& message, uint8_t* wire) {
  return encode_framed(header, tg_HostMessage_fields, &message, wire);
}

size_t encode_message(FrameHeader header, const tg_MachineMessage& message, uint8_t* wire) {
  return encode_framed(header, tg_MachineMessage_fields, &message, wire);
}

size_t encode_payload(const tg_MachineMessage& message, uint8_t* payload) {
  return encode_fields(tg_MachineMessage_fields, &message, payload);
}

size_t encode_payload(const tg_Config& part, uint8_t* payload) {
  return encode_fields(tg_Config_fields, &part, payload);
}

size_t encode_calibration(const tg_Calibration& calibration, uint8_t* record) {
  return encode_fields(tg_Calibration_fields, &calibration, record, tg_Calibration_size);
}

bool decode_calibration(const uint8_t* record, size_t bytes, tg_Calibration* calibration) {
  pb_istream_t stream = pb_istream_from_buffer(record, bytes);
  return pb_decode(&stream, tg_Calibration_fields, calibration);
}

bool decode_message(const Frame& frame, tg_HostMessage* message) {
  return decode_fields(tg_HostMessage_fields, frame, message) && message->which_body != 0;
}

bool decode_message(const Frame& frame, tg_MachineMessage* message) {
  return decode_fields(tg_MachineMessage_fields, frame, message) && message->which_body != 0;
}

}  // namespace tetragauge
