// SPDX-License-Identifier: Apache-2.0
#include "protocol/message.hpp"

#include <pb_decode.h>
#include <pb_encode.h>

#include <cstring>

#include "protocol/encode_points.hpp"

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

// nanopb puts any number into an enumeration, and reading one beyond its bits is undefined in C++: looked at
// as bytes before anybody reads it.
template <class Enumeration>
bool known(const Enumeration& field, Enumeration last) {
  unsigned int value = 0;
  static_assert(sizeof field <= sizeof value);  // one byte on ARM; both ends are little-endian
  std::memcpy(&value, &field, sizeof field);
  return value <= static_cast<unsigned int>(last);
}

bool known_values(const tg_CameraConfig& camera) {
  return known(camera.detector, _tg_DetectorType_MAX);
}

bool known_values(const tg_HostMessage& message) {
  switch (message.which_body) {
    case tg_HostMessage_get_config_tag:
      return known(message.body.get_config.part, _tg_ConfigPart_MAX);
    case tg_HostMessage_set_config_tag:
      return message.body.set_config.which_part != tg_Config_camera_tag ||
             known_values(message.body.set_config.part.camera);
    case tg_HostMessage_jog_tag:
      return known(message.body.jog.axis, _tg_AxisName_MAX);
    case tg_HostMessage_move_axis_tag:
      return known(message.body.move_axis.axis, _tg_AxisName_MAX);
    default:
      return true;
  }
}

bool known_values(const tg_MachineMessage& message) {
  const auto& body = message.body;
  switch (message.which_body) {
    case tg_MachineMessage_hello_reply_tag:
      return known(body.hello_reply.state, _tg_State_MAX) &&
             known(body.hello_reply.reset_cause, _tg_ResetCause_MAX);
    case tg_MachineMessage_status_tag:
      return known(body.status.state, _tg_State_MAX) && known(body.status.fault, _tg_FaultCode_MAX);
    case tg_MachineMessage_heartbeat_tag:
      return known(body.heartbeat.state, _tg_State_MAX) && known(body.heartbeat.fault, _tg_FaultCode_MAX);
    case tg_MachineMessage_fault_tag:
      return known(body.fault.code, _tg_FaultCode_MAX);
    case tg_MachineMessage_refused_tag:
      return known(body.refused.reason, _tg_RefuseReason_MAX) && known(body.refused.state, _tg_State_MAX);
    case tg_MachineMessage_config_tag:
      return body.config.which_part != tg_Config_camera_tag || known_values(body.config.part.camera);
    case tg_MachineMessage_scan_end_tag:
      return known(body.scan_end.fault, _tg_FaultCode_MAX);
    case tg_MachineMessage_self_test_tag:
      for (pb_size_t k = 0; k < body.self_test.items_count; ++k) {
        const tg_SelfTestItem& item = body.self_test.items[k];
        if (!known(item.check, _tg_SelfTestCheck_MAX) || !known(item.result, _tg_SelfTestResult_MAX))
          return false;
      }
      return true;
    case tg_MachineMessage_log_tag:
      return known(body.log.level, _tg_LogLevel_MAX);
    default:
      return true;
  }
}

}  // namespace

size_t encode_message(FrameHeader header, const tg_HostMessage& message, uint8_t* wire) {
  uint8_t payload[kFramePayloadBytes];
  const size_t bytes = encode_fields(tg_HostMessage_fields, &message, payload);
  return bytes == 0 ? 0 : encode_frame(header, payload, bytes, wire);
}

size_t encode_message(FrameHeader header, const tg_MachineMessage& message, uint8_t* wire) {
  uint8_t payload[kFramePayloadBytes];
  const size_t bytes = encode_payload(message, payload);
  return bytes == 0 ? 0 : encode_frame(header, payload, bytes, wire);
}

size_t encode_payload(const tg_MachineMessage& message, uint8_t* payload) {
  if (message.which_body == tg_MachineMessage_points_tag)
    return encode_points(message.body.points, payload, kFramePayloadBytes);
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
  return pb_decode(&stream, tg_Calibration_fields, calibration) && known_values(calibration->camera_1) &&
         known_values(calibration->camera_2);
}

bool decode_message(const Frame& frame, tg_HostMessage* message) {
  return decode_fields(tg_HostMessage_fields, frame, message) && message->which_body != 0 &&
         known_values(*message);
}

bool decode_message(const Frame& frame, tg_MachineMessage* message) {
  return decode_fields(tg_MachineMessage_fields, frame, message) && message->which_body != 0 &&
         known_values(*message);
}

}  // namespace tetragauge
