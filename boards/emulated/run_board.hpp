// SPDX-License-Identifier: Apache-2.0
// The emulated board's life: an event loop in virtual time that calls the firmware's interrupts at their
// instants.
//
// Virtual time stands still while the host owes an answer (host_debts.hpp) or while the machine rests, and
// bytes of the host are taken in only then: so they are stamped at an instant that does not depend on how
// fast either side runs, and the same commands give the same run. Time does not stand still for what the line
// has lost: it goes on until the next item or heartbeat tells the host. A host that keeps the machine waiting
// for 5 s of wall time counts as silent: time goes on without it, at wall pace, and the firmware's own
// time-outs see the silence.
#pragma once

#include <atomic>
#include <optional>

#include "boards/emulated/board_firmware.hpp"

namespace tetragauge {

struct PaceOptions {
  std::optional<double> speed;  // virtual seconds per wall second; none: as fast as it goes
  int silence_after_ms = 5000;
};

// Until the host goes, `stop` is set, or the firmware was sent into its bootloader; an error when the
// firmware cannot be run any more. A reboot starts it anew. A machine whose host has gone switches the laser
// off by its own time-out; here it simply ends.
Status run_board(EmulatedBoard& board, BoardFirmware& firmware, HostLine& line, const std::atomic<bool>& stop,
                 const PaceOptions& pace = {});

}  // namespace tetragauge
