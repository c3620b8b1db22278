// SPDX-License-Identifier: GPL-3.0-or-later
// Fuzzes what reads bytes that others wrote. The first byte chooses: 0 a line of bytes into the frame reader,
// and what it accepts into the decoders; 1 a payload into the decoders at once, past the CRC that no fuzzer
// gets right.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "firmware/machine_config.hpp"
#include "protocol/beam_record.hpp"
#include "protocol/message.hpp"

namespace {

using namespace tetragauge;

void must(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

// What decodes can be encoded, and then stands for the same bytes for good.
template <class Message>
void encode_again(const Message& message) {
  uint8_t wire[kFrameWireBytes], wire_again[kFrameWireBytes];
  const size_t bytes = encode_message({Channel::kEvent, 1}, message, wire);
  if (bytes == 0) return;  // written shorter than any encoder would, it need not fit a frame
  FrameReader reader;
  bool came = false;
  for (size_t i = 0; i < bytes; ++i) came = reader.push(wire[i]);
  must(came, "an encoded frame is accepted");
  Message again = {};
  must(decode_message(reader.frame(), &again), "an encoded message decodes");
  const size_t bytes_again = encode_message({Channel::kEvent, 1}, again, wire_again);
  must(bytes_again == bytes && std::memcmp(wire, wire_again, bytes) == 0, "and encodes to the same bytes");
}

void unpack(const tg_PointBatch& batch) {
  BeamRecord beams[kBatchBeams];
  const uint32_t count = beams_of_batch(batch, beams);
  must(count <= kBatchBeams, "a batch holds no more beams than its bound");
  BatchBuilder builder;
  builder.start(batch.plan_id, batch.view, batch.table_udeg, batch.slide_um);
  uint32_t packed = 0;
  while (packed < count && builder.add(beams[packed])) ++packed;
  if (packed == 0) return;
  BeamRecord unpacked[kBatchBeams];
  must(beams_of_batch(builder.batch(), unpacked) == packed, "packed beams unpack");
  for (uint32_t i = 0; i < packed; ++i) must(unpacked[i] == beams[i], "to what they were");
}

void decode(const Frame& frame) {
  tg_HostMessage host = {};
  if (decode_message(frame, &host)) {
    encode_again(host);
    if (host.which_body == tg_HostMessage_set_config_tag && config_error(host.body.set_config) == nullptr) {
      MachineConfig config = nominal_config();
      set_part(&config, host.body.set_config);
      geometry_of<float>(config);
    }
  }
  tg_MachineMessage machine = {};
  if (decode_message(frame, &machine)) {
    encode_again(machine);
    if (machine.which_body == tg_MachineMessage_points_tag) unpack(machine.body.points);
  }
  tg_Calibration calibration = {};
  if (decode_calibration(frame.payload, frame.payload_bytes, &calibration)) calibration_error(calibration);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  if (data[0] == 0) {
    FrameReader reader;
    for (size_t i = 1; i < size; ++i) {
      if (reader.push(data[i])) decode(reader.frame());
    }
  } else if (size - 1 <= kFramePayloadBytes) {
    // A copy, so that reading past its end is seen.
    const std::vector<uint8_t> payload(data + 1, data + size);
    decode({{Channel::kRequest, 1}, payload.data(), payload.size()});
  }
  return 0;
}
