// SPDX-License-Identifier: GPL-3.0-or-later
// A byte stream to a machine, whatever it hangs on:
//
//   auto transport = open_transport("/dev/ttyUSB0");     // a serial port, through libserialport
//   auto transport = open_transport("unix:/run/tg.sock"); // an emulated machine
//   auto transport = open_transport("tcp:bench-3:4000");  // QEMU, a network serial server
//
// Every failure is ErrorKind::machine (a malformed device name ErrorKind::usage) and says what to do next.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "host/base/result.hpp"

namespace tetragauge {

struct TransportOptions {
  int baud = 921600;  // serial ports only
  std::chrono::milliseconds connect_timeout{3000};
};

class Transport {
 public:
  Transport() = default;
  virtual ~Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  // Waits for bytes up to `timeout` and takes what is there; 0: none came. Error: the line is gone.
  virtual Result<size_t> read_some(std::span<uint8_t> buffer, std::chrono::milliseconds timeout) = 0;
  // All of them, or an error when the other side does not take them within `timeout`.
  virtual Status write_all(std::span<const uint8_t> bytes, std::chrono::milliseconds timeout) = 0;
  // The device as the user gave it, for messages.
  virtual const std::string& device() const = 0;
};

Result<std::unique_ptr<Transport>> open_transport(const std::string& device,
                                                  const TransportOptions& options = {});

}  // namespace tetragauge
