// SPDX-License-Identifier: GPL-3.0-or-later
// The options that name a machine, real or emulated, and open it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/link/link.hpp"
#include "host/session/emulated_machine.hpp"

namespace tetragauge::cli {

struct OpenMachine {
  std::unique_ptr<EmulatedMachine> emulated;  // empty: a machine somebody else runs
  std::unique_ptr<Link> link;                 // ends before the machine does

  // An error of the link, with what an emulated machine has to say to it.
  Error explain(Error error) const;
};

inline constexpr const char* kBaudHelp =
    "Of a serial port: 921600, or 2000000 where the board's jumper says so";

struct MachineArguments {
  std::string port;
  int baud = TransportOptions{}.baud;
  EmulatedMachineOptions emulated;

  void add(CLI::App& command);
  // Usage errors that can be known before a machine is touched.
  Status check() const;
  // Starts the emulated one, says Hello.
  Result<OpenMachine> open() const;
};

}  // namespace tetragauge::cli
