// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/link/serial_transport.hpp"

#include <libserialport.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace tetragauge {
namespace {

using std::chrono::milliseconds;

struct PortDeleter {
  void operator()(sp_port* port) const {
    sp_close(port);
    sp_free_port(port);
  }
};
using Port = std::unique_ptr<sp_port, PortDeleter>;

// "; ports here: /dev/ttyACM0, /dev/ttyUSB1"
std::string ports_here() {
  sp_port** list = nullptr;
  if (sp_list_ports(&list) != SP_OK) return "";
  std::string names;
  for (sp_port** port = list; *port != nullptr; ++port) {
    names += (names.empty() ? "" : ", ") + std::string(sp_get_port_name(*port));
  }
  sp_free_port_list(list);
  return names.empty() ? "; no serial port is plugged in" : "; ports here: " + names;
}

class SerialTransport final : public Transport {
 public:
  SerialTransport(Port port, int fd, std::string device)
      : port_(std::move(port)), fd_(fd), device_(std::move(device)) {}

  Result<size_t> read_some(std::span<uint8_t> buffer, milliseconds timeout) override {
    pollfd waiting{fd_, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(timeout.count()));
    if (ready == 0 || (ready < 0 && errno == EINTR)) return size_t{0};
    const int n = sp_nonblocking_read(port_.get(), buffer.data(), buffer.size());
    if (n < 0) return unplugged();
    // A port that is readable and yet gives nothing has hung up.
    if (n == 0 && (waiting.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return unplugged();
    if (n == 0 && ::access(device_.c_str(), F_OK) != 0) return unplugged();
    return static_cast<size_t>(n);
  }

  Status write_all(std::span<const uint8_t> bytes, milliseconds timeout) override {
    const int n =
        sp_blocking_write(port_.get(), bytes.data(), bytes.size(), static_cast<unsigned>(timeout.count()));
    if (n < 0) return unplugged();
    if (static_cast<size_t>(n) != bytes.size()) {
      return machine_error(device_ +
                           ": the port takes no bytes; unplug the machine, plug it in again and repeat");
    }
    return Done{};
  }

  const std::string& device() const override { return device_; }

 private:
  Error unplugged() const {
    return machine_error(device_ +
                         ": the machine was unplugged; check cable and power, then repeat the command");
  }

  Port port_;
  int fd_;
  std::string device_;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_serial_transport(const std::string& device,
                                                         const TransportOptions& options) {
  struct stat info {};
  if (::stat(device.c_str(), &info) != 0) {
    return machine_error(device + ": no such port" + ports_here());
  }
  if (!S_ISCHR(info.st_mode)) {
    return machine_error(device + ": not a serial port (a socket is written unix:" + device + ")");
  }
  sp_port* raw = nullptr;
  if (sp_get_port_by_name(device.c_str(), &raw) != SP_OK) {
    return machine_error(device + ": not a serial port that libserialport knows" + ports_here());
  }
  Port port(raw);
  if (sp_open(port.get(), SP_MODE_READ_WRITE) != SP_OK) {
    const int failure = sp_last_error_code();
    if (failure == EACCES) {
      return machine_error(device +
                           ": no permission; add yourself to the group that owns it (on Debian: sudo "
                           "adduser $USER dialout), then log in again");
    }
    if (failure == EBUSY) {
      return machine_error(device + ": in use by another program; end that one first");
    }
    return machine_error(device + ": cannot open it as a serial port: " + std::strerror(failure));
  }
  const bool configured =
      sp_set_baudrate(port.get(), options.baud) == SP_OK && sp_set_bits(port.get(), 8) == SP_OK &&
      sp_set_parity(port.get(), SP_PARITY_NONE) == SP_OK && sp_set_stopbits(port.get(), 1) == SP_OK &&
      sp_set_flowcontrol(port.get(), SP_FLOWCONTROL_NONE) == SP_OK;
  if (!configured) {
    return machine_error(device + ": does not take " + std::to_string(options.baud) +
                         " baud, 8N1, no flow control; use the machine's own USB port");
  }
  sp_flush(port.get(), SP_BUF_BOTH);  // bytes of an earlier session
  int fd = -1;
  if (sp_get_port_handle(port.get(), &fd) != SP_OK) {
    return machine_error(device + ": the port gives no handle to wait on");
  }
  return std::unique_ptr<Transport>(std::make_unique<SerialTransport>(std::move(port), fd, device));
}

}  // namespace tetragauge
