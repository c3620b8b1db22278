// SPDX-License-Identifier: Apache-2.0
// tetragauge-emulator: the machine without hardware. The firmware's own code on an emulated board, with a
// simulated world around it, reached over a socket or a pseudo-terminal.
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <string>

#include "boards/emulated/file_storage.hpp"
#include "boards/emulated/listen.hpp"
#include "boards/emulated/native_firmware.hpp"
#include "boards/emulated/run_board.hpp"
#include "boards/mps2_an386/qemu_firmware.hpp"
#include "boards/mps2_an386/write_work.hpp"
#include "firmware/hal/memory_storage.hpp"
#include "host/solid/solid.hpp"
#include "sim/read_world.hpp"

namespace tetragauge {
namespace {

std::atomic<bool> stop_asked{false};

void ask_to_stop(int) {
  stop_asked = true;
}

struct Options {
  std::string part, board = "emulated", listen = "pty", speed = "max", place, world, store, faults, trace,
                    work;
  uint64_t seed = 1;
  bool one_host = false, own_folder = false;
};

// Takes the socket away at the end, and the folder when it was made for the socket alone: whoever started
// this program may have been killed before doing so.
struct AtEnd {
  std::string socket;            // empty: none of this program's
  std::filesystem::path folder;  // empty: somebody else's
  ~AtEnd() {
    if (!socket.empty()) ::unlink(socket.c_str());
    if (!folder.empty()) ::rmdir(folder.c_str());  // only an empty one goes
  }
};

Result<PaceOptions> pace_of(const std::string& speed) {
  if (speed == "max") return PaceOptions{};
  double factor = 0;
  const auto [end, failure] = std::from_chars(speed.data(), speed.data() + speed.size(), factor);
  if (failure != std::errc() || end != speed.data() + speed.size() || !(factor > 0 && factor <= 1e6)) {
    return usage_error("--speed " + speed + ": must be max, or how often faster than real time (1)");
  }
  return PaceOptions{.speed = factor};
}

// As the build lays them out: bin/tetragauge-emulator, images/BOARD/tetragauge-BOARD.elf.
std::filesystem::path image_beside_this_program() {
  std::error_code ignored;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", ignored);
  return self.parent_path().parent_path() / "images/mps2_an386/tetragauge-mps2_an386.elf";
}

Status end_of(const std::unique_ptr<Trace>& trace) {
  return trace ? trace->close() : Status(Done{});
}

Status first_failure(std::initializer_list<Status> all) {
  for (const Status& one : all)
    if (!one) return one;
  return Done{};
}

Status run(const Options& options) {
  AtEnd at_end;
  if (options.own_folder && options.listen.starts_with("unix:"))
    at_end.folder = std::filesystem::path(options.listen.substr(std::strlen("unix:"))).parent_path();
  const auto pace = pace_of(options.speed);
  if (!pace) return pace.error();
  RigidTransform place;
  if (!options.place.empty()) {
    const auto parsed = parse_pose(options.place, "--place");
    if (!parsed) return parsed.error();
    place = *parsed;
  }
  sim::WorldSetup setup;
  if (!options.world.empty()) {
    auto deviating = sim::read_world(options.world, setup);
    if (!deviating) return deviating.error();
    setup = *std::move(deviating);
  }
  sim::Faults faults;
  if (!options.faults.empty()) {
    const auto parsed = sim::parse_faults(options.faults);
    if (!parsed) return parsed.error();
    faults = *parsed;
    setup.faults = faults.machine;
  }
  const auto model = read_solid(options.part);
  if (!model) return model.error();
  const auto standing = sim::stand_on_table(*model, place, options.part);
  if (!standing) return standing.error();

  MemoryStorage forgotten;
  std::unique_ptr<FileStorage> lasting;
  if (!options.store.empty()) {
    auto opened = FileStorage::open(options.store);
    if (!opened) return opened.error();
    lasting = *std::move(opened);
  }
  Storage& store = lasting ? static_cast<Storage&>(*lasting) : forgotten;

  std::unique_ptr<Trace> trace;
  if (!options.trace.empty()) {
    auto opened = Trace::open(options.trace);
    if (!opened) return opened.error();
    trace = *std::move(opened);
  }

  std::unique_ptr<QemuProcess> qemu;
  if (options.board == "mps2_an386") {
    auto started = QemuProcess::start(image_beside_this_program());
    if (!started) return started.error();
    qemu = *std::move(started);
  }

  const auto listening = start_listening(options.listen);
  if (!listening) return listening.error();
  at_end.socket = listening->socket_path;
  // With --one-host, a reader who has gone is a host killed before it could be watched.
  if (std::printf("%s\n", listening->device.c_str()) < 0 || std::fflush(stdout) != 0)
    return machine_error("cannot say the device on standard output: " + std::string(std::strerror(errno)));

  HostLine line({.listener_fd = listening->listener_fd, .fd = listening->fd, .one_host = options.one_host},
                faults);
  sim::World world(setup, *standing, options.seed);
  EmulatedBoard board(world, line, store, std::random_device{}(), trace.get());
  if (qemu) {
    QemuFirmware firmware(board, store, std::move(qemu));
    const Status ran = run_board(board, firmware, line, stop_asked, *pace);
    const Status said = options.work.empty() ? Status(Done{}) : write_work(options.work, firmware);
    return first_failure({ran, said, end_of(trace)});
  }
  NativeFirmware firmware(board);
  const Status ran = run_board(board, firmware, line, stop_asked, *pace);
  return first_failure({ran, end_of(trace)});
}

int emulator_main(int argc, char** argv) {
  CLI::App app{
      "tetragauge-emulator: the measuring machine without hardware. Prints the device a host opens."};
  Options options;
  app.add_option("--part", options.part, "model of the part as really made (.step .stp .csg)")->required();
  app.add_option("--board", options.board,
                 "emulated, or mps2_an386: the firmware as code for a Cortex-M4F, run by QEMU")
      ->check(CLI::IsMember({"emulated", "mps2_an386"}))
      ->capture_default_str();
  app.add_option("--listen", options.listen, "unix:PATH, tcp:PORT or pty")->capture_default_str();
  app.add_option("--speed", options.speed, "max, or virtual seconds per second")->capture_default_str();
  app.add_option("--seed", options.seed, "of all noise")->capture_default_str();
  app.add_option("--place", options.place,
                 "RX,RY,RZ,TX,TY,TZ (degrees, mm): turns the model, stands it on the table, shifts it");
  app.add_option("--world", options.world, "JSON file of a world that deviates from the nominal one");
  app.add_option("--faults", options.faults,
                 "what goes wrong and when, e.g. interlock@2.5s,link_flip=1e-4 (words: sim/README.md)");
  app.add_option("--trace", options.trace,
                 "file for a line at every change of state, laser, view and fault, with its virtual time");
  app.add_option(
      "--work", options.work,
      "with --board mps2_an386: file for what the image's processor has done, by the machine's state");
  app.add_option("--store", options.store, "file of the machine's calibration store; without, it forgets");
  app.add_flag("--one-host", options.one_host,
               "end when the first host has gone, or when the program that started this one has");
  app.add_flag("--own-folder", options.own_folder,
               "with --listen unix:PATH: PATH's folder is for it alone and is removed at the end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : static_cast<int>(ErrorKind::usage);
  }
  struct sigaction action {};
  action.sa_handler = ask_to_stop;
  ::sigaction(SIGTERM, &action, nullptr);
  if (options.one_host) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    // Ctrl-C reaches the host too, which first tells the machine to abort.
    ::signal(SIGINT, SIG_IGN);
  } else {
    ::sigaction(SIGINT, &action, nullptr);
  }
  ::signal(SIGPIPE, SIG_IGN);

  const Status done = run(options);
  if (done) return 0;
  std::fprintf(stderr, "tetragauge-emulator: %s\n", done.error().message.c_str());
  return static_cast<int>(done.error().kind);
}

}  // namespace
}  // namespace tetragauge

int main(int argc, char** argv) {
  return tetragauge::emulator_main(argc, argv);
}
