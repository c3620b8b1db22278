// SPDX-License-Identifier: GPL-3.0-or-later
// An emulated machine of one's own: starts tetragauge-emulator on a private socket and ends it.
//
//   auto machine = EmulatedMachine::start({.part = "staircase.csg"});
//   auto transport = open_transport((*machine)->device());
//   auto link = Link::connect(std::move(*transport), kEmulatedLink);
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "host/base/result.hpp"
#include "host/link/link.hpp"

namespace tetragauge {

struct EmulatedMachineOptions {
  std::string board = "emulated";  // or mps2_an386: its firmware as code for a Cortex-M4F, run by QEMU
  std::filesystem::path part{};    // model of the part as really made
  std::string place{};             // RX,RY,RZ,TX,TY,TZ; empty: as modelled
  uint64_t seed = 1;
  std::filesystem::path world{};  // empty: the nominal world
  std::string faults{};           // what goes wrong and when (sim/README.md); empty: nothing
  std::filesystem::path trace{};  // empty: none is written
  std::string speed = "max";
  bool one_host = true;  // false: it waits for another host when one has gone, until it is ended here
  std::filesystem::path emulator{};                 // empty: tetragauge-emulator beside the running program
  std::chrono::milliseconds start_timeout{60'000};  // reading a large model takes its time
};

// An emulated machine that has ended closes its line at once; one that only keeps silent is waiting for a
// processor that others are using.
constexpr LinkOptions kEmulatedLink{.silence = std::chrono::seconds(30)};

class EmulatedMachine {
 public:
  // Errors are the emulator's own: bad model, part outside the working volume (bad input), ...
  static Result<std::unique_ptr<EmulatedMachine>> start(const EmulatedMachineOptions& options);
  ~EmulatedMachine();  // ends it within some seconds, even one that hangs, and removes its folder
  EmulatedMachine(const EmulatedMachine&) = delete;
  EmulatedMachine& operator=(const EmulatedMachine&) = delete;

  // For open_transport().
  const std::string& device() const { return device_; }
  pid_t process() const { return process_; }

  // Why it has ended by itself; nothing when it runs, or has ended without a word.
  std::optional<Error> failure();

 private:
  EmulatedMachine() = default;

  std::filesystem::path folder_;
  std::filesystem::path program_;
  std::string device_;
  pid_t process_ = -1;
  int said_ = -1;  // what it says on standard error
};

}  // namespace tetragauge
