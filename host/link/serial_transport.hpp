// SPDX-License-Identifier: GPL-3.0-or-later
// A serial port through libserialport. Called through open_transport().
#pragma once

#include "host/link/transport.hpp"

namespace tetragauge {

Result<std::unique_ptr<Transport>> open_serial_transport(const std::string& device,
                                                         const TransportOptions& options);

}  // namespace tetragauge
