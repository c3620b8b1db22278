// SPDX-License-Identifier: GPL-3.0-or-later
// For tests: a machine of one's own with a part on it, and a link to it.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "host/link/link.hpp"
#include "host/session/emulated_machine.hpp"
#include "host/session/run_scan.hpp"

namespace tetragauge {

struct EmulatedSession {
  std::unique_ptr<EmulatedMachine> machine;
  std::unique_ptr<Link> link;
};

inline Result<std::unique_ptr<Link>> connect_to(const EmulatedMachine& machine,
                                                const LinkOptions& options = kEmulatedLink) {
  auto transport = open_transport(machine.device());
  if (!transport) return transport.error();
  return Link::connect(std::move(*transport), options);
}

inline Result<EmulatedSession> start_session(EmulatedMachineOptions options,
                                             const LinkOptions& link_options = kEmulatedLink) {
  options.emulator = TETRAGAUGE_EMULATOR;
  EmulatedSession session;
  auto machine = EmulatedMachine::start(options);
  if (!machine) return machine.error();
  session.machine = std::move(*machine);
  auto link = connect_to(*session.machine, link_options);
  if (!link) return link.error();
  session.link = std::move(*link);
  return session;
}

// Both boards that can be emulated; the second needs its image, built where there is a compiler for it.
inline const std::string kEmulatedBoards[] = {"emulated", "mps2_an386"};

inline bool can_run(const std::string& board) {
  const std::filesystem::path build = std::filesystem::path(TETRAGAUGE_EMULATOR).parent_path().parent_path();
  return board == "emulated" ||
         std::filesystem::exists(build / "images" / board / ("tetragauge-" + board + ".elf"));
}

// A folder of this test program's own, removed at its end.
inline std::filesystem::path temporary_folder() {
  struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("tetragauge-test-" + std::to_string(::getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
  };
  static const Folder folder;
  return folder.path;
}

// A file in it.
inline std::filesystem::path temporary_file(const std::string& name, const std::string& content) {
  const auto path = temporary_folder() / name;
  std::ofstream(path) << content;
  return path;
}

inline std::filesystem::path box_file() {
  return temporary_file("box.csg", "cube(size = [40, 30, 50], center = false);\n");
}

// 8 views all round a part about 50 mm high, coarse.
inline ScanPlan plan_all_round(double pitch_mm, uint32_t samples = PlannedView{}.samples) {
  ScanPlan plan;
  for (int k = 0; k < 8; ++k) {
    PlannedView view;
    view.table_deg = 45.0 * k;
    view.slide_mm = 175;
    view.window = {.y_min_mm = -36, .y_max_mm = 36, .up_min_mm = -42, .up_max_mm = 42};
    view.pitch_mm = pitch_mm;
    view.samples = samples;
    plan.views.push_back(view);
  }
  return plan;
}

}  // namespace tetragauge
