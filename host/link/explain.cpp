// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/link/explain.hpp"

#include <cstdio>

#include "protocol/frame.hpp"
#include "protocol/schema_hash.hpp"

namespace tetragauge {

std::string_view explain_fault(tg_FaultCode code) {
  switch (code) {
    case tg_FaultCode_FAULT_NONE:
      return "no fault";
    case tg_FaultCode_FAULT_INTERLOCK:
      return "the interlock opened; close the cover and repeat the command";
    case tg_FaultCode_FAULT_MIRROR:
      return "a mirror driver reports failure; check its supply and plug, and that the mirror turns freely";
    case tg_FaultCode_FAULT_SIGNAL:
      return "a detector channel stays on its rail with the laser off; shade strong light, check the "
             "detector's plug";
    case tg_FaultCode_FAULT_LASER:
      return "the laser driver reports failure; check its supply and temperature";
    case tg_FaultCode_FAULT_LIMIT:
      return "a limit switch was hit; free the axis by hand and repeat the command, which homes again";
    case tg_FaultCode_FAULT_HOME_NOT_FOUND:
      return "an axis did not find its home switch; check the switch's plug, and that the axis moves freely";
    case tg_FaultCode_FAULT_HOME_STUCK:
      return "a home switch stays closed; clean it or check its plug";
    case tg_FaultCode_FAULT_SAMPLING:
      return "the converter did not deliver its samples in time; switch the machine off and on";
    case tg_FaultCode_FAULT_MISASSEMBLED:
      return "nearly every spot misses its beam: geometry and machine disagree; see whether camera or head "
             "were moved, "
             "and calibrate";
    case tg_FaultCode_FAULT_STORAGE:
      return "the calibration store could not be written; write the calibration again, and replace the "
             "controller "
             "if that repeats";
  }
  return "a fault this program does not know; update it";
}

std::string_view explain_reject(uint32_t reason) {
  switch (static_cast<tg_RejectReason>(reason)) {
    case tg_RejectReason_REJECT_NONE:
      return "none";
    case tg_RejectReason_REJECT_WEAK:
      return "too little light";
    case tg_RejectReason_REJECT_SATURATED:
      return "too much light";
    case tg_RejectReason_REJECT_AMBIENT:
      return "ambient light";
    case tg_RejectReason_REJECT_INCONSISTENT:
      return "beam and cameras disagree";
    case tg_RejectReason_REJECT_OUTSIDE_VOLUME:
      return "outside the working volume";
  }
  return "another reason";
}

std::string explain_mismatch(const tg_HelloReply& machine) {
  if (machine.protocol_version == kProtocolVersion && machine.schema_hash == kSchemaHash) return "";
  const std::string board = machine.board[0] != '\0' ? machine.board : "its board";
  char numbers[200];
  std::snprintf(
      numbers, sizeof numbers,
      "the machine's firmware %s speaks protocol %u (schema %08x), this program protocol %u (schema %08x)",
      machine.firmware_version, static_cast<unsigned>(machine.protocol_version),
      static_cast<unsigned>(machine.schema_hash), static_cast<unsigned>(kProtocolVersion),
      static_cast<unsigned>(kSchemaHash));
  if (board == "emulated") {
    return std::string(numbers) + "; start the tetragauge-emulator that was built together with this program";
  }
  return std::string(numbers) + "; flash the image tetragauge-" + board +
         ".elf that was built together with this program: script/flash " + board;
}

}  // namespace tetragauge
