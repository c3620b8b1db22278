// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/machine_options.hpp"

#include "host/geometry/parse_number.hpp"
#include "host/geometry/rigid_transform.hpp"

namespace tetragauge::cli {

void MachineArguments::add(CLI::App& command) {
  auto* port_option =
      command.add_option("--port", port, "Machine: /dev/ttyX, unix:PATH or tcp:HOST:PORT")->type_name("DEV");
  command.add_option("--baud", baud, kBaudHelp)
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(port_option);
  command.add_option("--emulated", emulated.part, "Emulated machine: model of the part as really made")
      ->type_name("PART")
      ->excludes(port_option);
  command
      .add_option("--board", emulated.board,
                  "Board of the emulated machine: emulated, or mps2_an386 (ARM code, by QEMU)")
      ->check(CLI::IsMember({"emulated", "mps2_an386"}))
      ->capture_default_str()
      ->excludes(port_option);
  command
      .add_option("--place", emulated.place,
                  "How the emulated part stands: turned (degrees), then shifted (mm)")
      ->type_name("RX,RY,RZ,TX,TY,TZ")
      ->excludes(port_option);
  command.add_option("--seed", emulated.seed, "Seed of the emulated machine's noise")
      ->capture_default_str()
      ->excludes(port_option);
  command.add_option("--world", emulated.world, "True geometry and noise of the emulated machine (JSON)")
      ->type_name("FILE")
      ->excludes(port_option);
  command.add_option("--faults", emulated.faults, "What goes wrong with the emulated machine, and when")
      ->type_name("SPEC")
      ->excludes(port_option);
  command.add_option("--speed", emulated.speed, "Time of the emulated machine: max, or 1 for real time")
      ->check(CLI::IsMember({"max", "1"}))
      ->capture_default_str()
      ->excludes(port_option);
}

Status MachineArguments::check() const {
  if (port.empty() == emulated.part.empty()) {
    return usage_error("name the machine: --port DEV for a real one, or --emulated PART");
  }
  if (port.starts_with("tcp:")) {
    const std::string number = port.substr(port.rfind(':') + 1);
    const auto value = parse_number<int>(number);
    if (!value || *value < 1 || *value > 65535) {
      return usage_error("--port " + port + ": must be tcp:HOST:PORT with a port from 1 to 65535");
    }
  }
  if (!emulated.place.empty()) {
    Result<RigidTransform> pose = parse_pose(emulated.place, "--place");
    if (!pose) return pose.error();
  }
  return Done{};
}

Result<OpenMachine> MachineArguments::open() const {
  OpenMachine machine;
  std::string device = port;
  if (!emulated.part.empty()) {
    Result<std::unique_ptr<EmulatedMachine>> started = EmulatedMachine::start(emulated);
    if (!started) return started.error();
    machine.emulated = std::move(*started);
    device = machine.emulated->device();
  }
  Result<std::unique_ptr<Transport>> transport = open_transport(device, {.baud = baud});
  if (!transport) return transport.error();
  Result<std::unique_ptr<Link>> link =
      Link::connect(std::move(*transport), machine.emulated ? kEmulatedLink : LinkOptions{});
  if (!link) return machine.explain(link.error());
  machine.link = std::move(*link);
  return machine;
}

Error OpenMachine::explain(Error error) const {
  if (!emulated || error.kind != ErrorKind::machine) return error;
  if (const auto failure = emulated->failure()) error.message += "\n" + failure->message;
  return error;
}

}  // namespace tetragauge::cli
