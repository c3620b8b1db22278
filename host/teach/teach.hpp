// SPDX-License-Identifier: GPL-3.0-or-later
// Teaching a plan at the machine, on a terminal:
//
//   teach({.plan_file = "plan.json", .connect = connect});
//
// Beside the plan it writes plan.preview.png at each preview, and plan.view-N.png for each view with one
// when it saves.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "host/link/link.hpp"
#include "host/teach/paint_preview.hpp"

namespace tetragauge {

struct TeachOptions {
  std::filesystem::path plan_file;  // where there is one already, teaching goes on from it
  // Opens the machine, or opens it again after it was lost; the link lives until the next call.
  std::function<Result<Link*>()> connect;
  TerminalColours colours = TerminalColours::none;
  std::function<void(const std::string&)> log{};  // before and after, when the screen is not the program's
};

struct Taught {
  size_t views = 0;
  bool saved = false;  // the file has them; false: left without saving, or there was nothing to save
};

// Errors (machine): it could not be reached at the start; later losses are told on the screen. Stopped by a
// signal, or its terminal gone: views not saved are kept in plan.rescue.json, and the error says so.
Result<Taught> teach(const TeachOptions& options);

}  // namespace tetragauge
