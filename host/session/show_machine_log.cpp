// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/show_machine_log.hpp"

namespace tetragauge {
namespace {

const char* manner_of(tg_LogLevel level) {
  switch (level) {
    case tg_LogLevel_LOG_WARNING:
      return "the machine warns: ";
    case tg_LogLevel_LOG_ERROR:
      return "the machine says, error: ";
    default:
      return "the machine says: ";
  }
}

}  // namespace

void show_machine_log(Link& link, const ScanOptions& options) {
  if (!options.log) return;
  while (const auto line = link.next_log()) options.log(manner_of(line->level) + std::string(line->text));
}

}  // namespace tetragauge
