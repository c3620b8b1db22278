// SPDX-License-Identifier: Apache-2.0
// Why the chip has started: RCC_CSR (RM0090 7.3.21). Every reset pulls the reset pin too, and a rise of the
// supply sets the brown-out flag, so the more particular ones are asked first. Asking forgets.
#pragma once

#include "boards/stm32_h405/registers/rcc.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

template <class Bus>
tg_ResetCause take_reset_cause() {
  using I = Io<Bus>;
  tg_ResetCause cause = tg_ResetCause_RESET_UNKNOWN;
  if (I::is(rcc::kIwdgReset(1)) || I::is(rcc::kWwdgReset(1))) {
    cause = tg_ResetCause_RESET_WATCHDOG;
  } else if (I::is(rcc::kSoftwareReset(1))) {
    cause = tg_ResetCause_RESET_SOFTWARE;
  } else if (I::is(rcc::kPowerReset(1)) || I::is(rcc::kBrownOutReset(1))) {
    cause = tg_ResetCause_RESET_POWER;
  } else if (I::is(rcc::kPinReset(1))) {
    cause = tg_ResetCause_RESET_PIN;
  }
  I::modify(rcc::kForgetResets(1));
  return cause;
}

}  // namespace tetragauge
