// SPDX-License-Identifier: Apache-2.0
// What the image's processor has done, one line for each state of the machine and thing that came in it:
//
//   state,event,turns,instructions
//   SCANNING,samples,61324,52309315
//
// Instructions are counted by the board's timer, each turn to within 5. Equal scans give equal counts, but
// for the frames of the host (event line): how often it asks depends on how long it waited.
#pragma once

#include <string>

#include "boards/mps2_an386/qemu_firmware.hpp"

namespace tetragauge {

// A file that is there is replaced.
Status write_work(const std::string& path, const QemuFirmware& firmware);

}  // namespace tetragauge
