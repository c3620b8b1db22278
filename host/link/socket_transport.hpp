// SPDX-License-Identifier: GPL-3.0-or-later
// Sockets as transports: "unix:PATH" and "tcp:HOST:PORT". Called through open_transport().
#pragma once

#include "host/link/transport.hpp"

namespace tetragauge {

Result<std::unique_ptr<Transport>> open_unix_transport(const std::string& device,
                                                       const TransportOptions& options);
Result<std::unique_ptr<Transport>> open_tcp_transport(const std::string& device,
                                                      const TransportOptions& options);

}  // namespace tetragauge
