// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an386/write_work.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "protocol/state_name.hpp"

namespace tetragauge {
namespace {

constexpr const char* kEvents[] = {"start", "table_step", "slide_step", "interlock",
                                   "alarm", "samples",    "poll",       "line"};
static_assert(std::size(kEvents) == std::tuple_size_v<QemuFirmware::WorkTable::value_type>);

}  // namespace

Status write_work(const std::string& path, const QemuFirmware& firmware) {
  std::ofstream file(path);
  file << "state,event,turns,instructions\n";
  for (size_t state = 0; state < firmware.work().size(); ++state) {
    for (size_t event = 0; event < std::size(kEvents); ++event) {
      const QemuFirmware::Work& work = firmware.work()[state][event];
      if (work.turns == 0) continue;
      file << state_name(static_cast<tg_State>(state)) << ',' << kEvents[event] << ',' << work.turns << ','
           << work.ticks * mps2_bus::kTickNs / mps2_bus::kInstructionNs << '\n';
    }
  }
  file.close();
  if (file) return Done{};
  return machine_error("--work " + path + ": cannot be written: " + std::strerror(errno) +
                       "; choose a file in a folder that you may write to");
}

}  // namespace tetragauge
