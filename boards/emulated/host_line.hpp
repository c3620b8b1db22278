// SPDX-License-Identifier: Apache-2.0
// The emulated board's serial line to its host: a socket or a pseudo-terminal. With a listener, the cable can
// be plugged into one host after another; without, the line is closed for good when the host has gone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace tetragauge {

class HostLine {
 public:
  struct Descriptors {
    int listener_fd = -1;  // -1: none
    int fd = -1;           // -1: no host yet
    bool one_host = true;  // closed when the first host has gone
  };
  explicit HostLine(const Descriptors& descriptors);  // takes them
  ~HostLine();
  HostLine(const HostLine&) = delete;
  HostLine& operator=(const HostLine&) = delete;

  // Waits up to `timeout_ms` of wall time for bytes of the host (or for a host) and takes them in.
  bool wait_for_bytes(int timeout_ms);
  // The host has gone and none will come.
  bool closed() const { return closed_; }

  // The board's side: what has been taken in, and what goes out. Without a host bytes go nowhere, as on a
  // real line.
  size_t read(uint8_t* bytes, size_t capacity);
  size_t write(const uint8_t* bytes, size_t count);

 private:
  void host_gone();

  int listener_fd_, fd_;
  bool one_host_;
  bool closed_ = false;
  std::deque<uint8_t> received_;
};

}  // namespace tetragauge
