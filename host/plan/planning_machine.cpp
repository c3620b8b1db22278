// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/planning_machine.hpp"

namespace tetragauge {
namespace {

PlanningMachine machine_of(const MachineConfig& config) {
  PlanningMachine machine;
  machine.config = config;
  machine.head = head_geometry(config.galvo, config.stage);
  machine.geometry = geometry_of<double>(config);
  return machine;
}

}  // namespace

PlanningMachine nominal_machine() {
  return machine_of(nominal_config());
}

Result<PlanningMachine> read_machine(Link& link) {
  MachineConfig config;
  for (int part = tg_ConfigPart_CONFIG_GALVO; part <= tg_ConfigPart_CONFIG_VOLUME; ++part) {
    const auto read = link.config(static_cast<tg_ConfigPart>(part));
    if (!read) return read.error();
    const char* wrong = config_error(*read);
    if (wrong != nullptr) {
      return machine_error(link.device() + ": the machine sent a configuration that cannot be used (" +
                           wrong + "); flash firmware of this version");
    }
    set_part(&config, *read);
  }
  PlanningMachine machine = machine_of(config);
  machine.sample_period_ns = link.machine().sample_period_ns;
  machine.max_views = link.machine().max_views;
  return machine;
}

}  // namespace tetragauge
