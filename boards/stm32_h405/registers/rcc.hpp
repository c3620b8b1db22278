// SPDX-License-Identifier: Apache-2.0
// Reset and clock control; power; flash wait states. RM0090 sections 7.3 (RCC), 5.4 (PWR), 3.9 (FLASH).
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::rcc {

using Cr = Register<0x40023800>;  // 7.3.1
inline constexpr Field<Cr, 16> kHseOn;
inline constexpr Field<Cr, 17> kHseReady;
inline constexpr Field<Cr, 24> kPllOn;
inline constexpr Field<Cr, 25> kPllReady;

using PllCfgr = Register<0x40023804>;  // 7.3.2
inline constexpr Field<PllCfgr, 0, 6> kPllM;
inline constexpr Field<PllCfgr, 6, 9> kPllN;
inline constexpr Field<PllCfgr, 16, 2> kPllP;  // 0: / 2
inline constexpr Field<PllCfgr, 22> kPllFromHse;
inline constexpr Field<PllCfgr, 24, 4> kPllQ;

using Cfgr = Register<0x40023808>;  // 7.3.3
inline constexpr Field<Cfgr, 0, 2> kSwitch;
inline constexpr Field<Cfgr, 2, 2> kSwitched;
inline constexpr uint32_t kToPll = 2;
inline constexpr Field<Cfgr, 4, 4> kAhbDivider;
inline constexpr Field<Cfgr, 10, 3> kApb1Divider;
inline constexpr Field<Cfgr, 13, 3> kApb2Divider;

using Ahb1Enr = Register<0x40023830>;  // 7.3.10
inline constexpr Field<Ahb1Enr, 0> kGpioAOn;
inline constexpr Field<Ahb1Enr, 1> kGpioBOn;
inline constexpr Field<Ahb1Enr, 2> kGpioCOn;
inline constexpr Field<Ahb1Enr, 22> kDma2On;

using Ahb2Enr = Register<0x40023834>;  // 7.3.11
inline constexpr Field<Ahb2Enr, 6> kRngOn;

using Apb1Enr = Register<0x40023840>;  // 7.3.13
inline constexpr Field<Apb1Enr, 0> kTim2On;
inline constexpr Field<Apb1Enr, 2> kTim4On;
inline constexpr Field<Apb1Enr, 3> kTim5On;
inline constexpr Field<Apb1Enr, 14> kSpi2On;
inline constexpr Field<Apb1Enr, 28> kPwrOn;
inline constexpr Field<Apb1Enr, 29> kDacOn;

using Apb2Enr = Register<0x40023844>;  // 7.3.14
inline constexpr Field<Apb2Enr, 1> kTim8On;
inline constexpr Field<Apb2Enr, 4> kUsart1On;
inline constexpr Field<Apb2Enr, 8> kAdc1On;
inline constexpr Field<Apb2Enr, 9> kAdc2On;
inline constexpr Field<Apb2Enr, 14> kSyscfgOn;

using Csr = Register<0x40023874>;  // 7.3.21
inline constexpr Field<Csr, 24> kForgetResets;
inline constexpr Field<Csr, 25> kBrownOutReset;
inline constexpr Field<Csr, 26> kPinReset;
inline constexpr Field<Csr, 27> kPowerReset;
inline constexpr Field<Csr, 28> kSoftwareReset;
inline constexpr Field<Csr, 29> kIwdgReset;
inline constexpr Field<Csr, 30> kWwdgReset;

// Clocks of peripherals. Read back: a peripheral takes no access in the cycles right after (errata sheet
// ES0182, "Delay after an RCC peripheral clock enabling").
template <class Bus, class R>
void switch_on(Bits<R> bits) {
  Io<Bus>::modify(bits);
  Io<Bus>::read(R{});
}

}  // namespace tetragauge::rcc

namespace tetragauge::pwr {

using Cr = Register<0x40007000>;  // 5.4.1
inline constexpr Field<Cr, 14> kVoltageScale1;

}  // namespace tetragauge::pwr

namespace tetragauge::syscfg {

using MemRmp = Register<0x40013800>;  // 9.2.1
inline constexpr Field<MemRmp, 0, 2> kMemMode;
inline constexpr uint32_t kSystemFlashAtZero = 1;

}  // namespace tetragauge::syscfg
