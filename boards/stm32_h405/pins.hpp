// SPDX-License-Identifier: Apache-2.0
// Which pin is what. docs/machine.md has the same as a table with the wiring; the two must agree
// (pins_test.py).
#pragma once

#include "boards/stm32_h405/registers/gpio.hpp"

namespace tetragauge::pins {

using gpio::Pin;
using gpio::PortName;

using LineOut = Pin<PortName::kA, 9>;   // USART1_TX, function 7
using LineIn = Pin<PortName::kA, 10>;   // USART1_RX
using FastLine = Pin<PortName::kA, 1>;  // jumper to 3.3 V: 2,000,000 baud
inline constexpr uint32_t kUsartFunction = 7;

using MirrorA = Pin<PortName::kA, 4>;  // DAC_OUT1
using MirrorB = Pin<PortName::kA, 5>;  // DAC_OUT2
using DacSelect = Pin<PortName::kB, 10>;
using DacClock = Pin<PortName::kB, 13>;  // SPI2_SCK, function 5
using DacLoad = Pin<PortName::kB, 11>;
using DacData = Pin<PortName::kB, 15>;  // SPI2_MOSI
inline constexpr uint32_t kSpiFunction = 5;

// Electrodes x1 x2 y1 y2: camera 1 on ADC1's inputs 10 to 13, camera 2 on ADC2's inputs 6 to 9.
using Camera1X1 = Pin<PortName::kC, 0>;
using Camera1X2 = Pin<PortName::kC, 1>;
using Camera1Y1 = Pin<PortName::kC, 2>;
using Camera1Y2 = Pin<PortName::kC, 3>;
using Camera2X1 = Pin<PortName::kA, 6>;
using Camera2X2 = Pin<PortName::kA, 7>;
using Camera2Y1 = Pin<PortName::kB, 0>;
using Camera2Y2 = Pin<PortName::kB, 1>;

using TableStep = Pin<PortName::kA, 2>;  // TIM2_CH3, function 1
using SlideStep = Pin<PortName::kA, 3>;  // TIM2_CH4
inline constexpr uint32_t kStepFunction = 1;
using TableUp = Pin<PortName::kC, 6>;  // direction: high is counter-clockwise
using SlideUp = Pin<PortName::kC, 7>;  // direction: high is up
using MotorsOn = Pin<PortName::kC, 8>;

using Interlock = Pin<PortName::kB, 6>;  // TIM4_CH1, function 2; high: closed
inline constexpr uint32_t kInterlockFunction = 2;
using MirrorsGood = Pin<PortName::kB, 7>;
using LaserGood = Pin<PortName::kB, 8>;
using TableHome = Pin<PortName::kB, 9>;
using SlideHome = Pin<PortName::kB, 5>;
using SlideNotLow = Pin<PortName::kC, 9>;  // low: on the switch, or its wire is broken
using SlideNotHigh = Pin<PortName::kC, 10>;

// Two that the chip's boot ROM leaves alone: it has a serial port on PB10 and PB11 (AN2606, STM32F40xxx).
using LaserOn = Pin<PortName::kB, 12>;
using LaserKick = Pin<PortName::kB, 14>;

using Light = Pin<PortName::kC, 12>;  // the board's own, on when low

}  // namespace tetragauge::pins
