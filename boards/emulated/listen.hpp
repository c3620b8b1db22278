// SPDX-License-Identifier: Apache-2.0
// Where an emulated machine can be reached: "unix:PATH", "tcp:PORT" (this computer only) or "pty".
#pragma once

#include <string>

#include "host/base/result.hpp"

namespace tetragauge {

struct Listening {
  int listener_fd = -1;       // sockets: accepts hosts
  int fd = -1;                // pseudo-terminal: the line itself
  std::string device;         // what a host opens: unix:PATH, tcp:localhost:PORT, /dev/pts/N
  std::string socket_path{};  // to be removed at the end; empty if none
};

// A socket file left by an emulator that died is replaced; one that somebody listens on is an error.
Result<Listening> start_listening(const std::string& where);

}  // namespace tetragauge
