// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/link/serial_transport.hpp"
#include "host/link/socket_transport.hpp"
#include "host/link/transport.hpp"

namespace tetragauge {

Result<std::unique_ptr<Transport>> open_transport(const std::string& device,
                                                  const TransportOptions& options) {
  if (device.starts_with("unix:")) return open_unix_transport(device, options);
  if (device.starts_with("tcp:")) return open_tcp_transport(device, options);
  if (device.empty()) {
    return usage_error("the device is empty; give a serial port (/dev/ttyUSB0), unix:PATH or tcp:HOST:PORT");
  }
  return open_serial_transport(device, options);
}

}  // namespace tetragauge
