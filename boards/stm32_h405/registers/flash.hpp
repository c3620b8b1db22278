// SPDX-License-Identifier: Apache-2.0
// The flash interface: wait states, erasing, programming. RM0090 section 3.9.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::flash {

using Acr = Register<0x40023C00>;  // 3.9.1
inline constexpr Field<Acr, 0, 3> kLatency;
inline constexpr Field<Acr, 8> kPrefetchOn;
inline constexpr Field<Acr, 9> kInstructionCacheOn;
inline constexpr Field<Acr, 10> kDataCacheOn;
inline constexpr Field<Acr, 12> kDataCacheReset;

using Keyr = Register<0x40023C04>;  // 3.9.3; the keys: 3.6.1
inline constexpr uint32_t kKey1 = 0x45670123, kKey2 = 0xCDEF89AB;

using Sr = Register<0x40023C0C>;  // 3.9.5; errors are cleared by writing 1
inline constexpr Field<Sr, 0> kEndOfOperation;
inline constexpr Field<Sr, 1> kOperationError;
inline constexpr Field<Sr, 4, 4> kErrors;  // write protection, alignment, parallelism, sequence
inline constexpr Field<Sr, 16> kBusy;

using Cr = Register<0x40023C10>;  // 3.9.6
inline constexpr Field<Cr, 0> kProgram;
inline constexpr Field<Cr, 1> kSectorErase;
inline constexpr Field<Cr, 3, 4> kSector;
inline constexpr Field<Cr, 8, 2> kParallelism;
inline constexpr uint32_t kBy32 = 2;  // 2.7 to 3.6 V, table 7
inline constexpr Field<Cr, 16> kStart;
inline constexpr Field<Cr, 31> kLock;

}  // namespace tetragauge::flash
