// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/emulated_machine.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

extern char** environ;

namespace tetragauge {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// How long an emulator that has closed its line may take to say why.
constexpr int kLastWord_ms = 1000;

struct Pipe {
  std::array<int, 2> ends{-1, -1};
  int take(size_t end) { return std::exchange(ends[end], -1); }
  bool open() { return ::pipe2(ends.data(), O_CLOEXEC) == 0; }
  void close(size_t end) {
    if (ends[end] >= 0) ::close(ends[end]);
    ends[end] = -1;
  }
  ~Pipe() {
    close(0);
    close(1);
  }
};

std::filesystem::path beside_this_program() {
  std::error_code ignored;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", ignored);
  return self.parent_path() / "tetragauge-emulator";
}

// Reads until a line is complete or the pipe ends; empty when neither happened in time.
std::string first_line(int fd, milliseconds timeout) {
  const auto deadline = steady_clock::now() + timeout;
  std::string text;
  for (;;) {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now()).count();
    pollfd waiting{fd, POLLIN, 0};
    if (left <= 0) return "";
    if (::poll(&waiting, 1, static_cast<int>(left)) <= 0) continue;  // a signal, or time is up
    std::array<char, 256> buffer;
    const ssize_t count = ::read(fd, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(buffer.data(), static_cast<size_t>(count));
    if (text.find('\n') != std::string::npos) return text.substr(0, text.find('\n'));
  }
}

std::string all_text(int fd) {
  std::string text;
  std::array<char, 1024> buffer;
  for (;;) {
    const ssize_t count = ::read(fd, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    text.append(buffer.data(), static_cast<size_t>(count));
  }
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

// Ends the child in bounded time, whatever it does: one that is stopped or hangs never sees SIGTERM. Its
// status.
int end_process(pid_t process) {
  constexpr milliseconds kGrace{1000};
  const auto deadline = steady_clock::now() + kGrace;
  int status = 0;
  for (int signal = SIGTERM;; signal = 0) {
    const pid_t ended = ::waitpid(process, &status, WNOHANG);
    if (ended == process || (ended < 0 && errno != EINTR)) return status;
    if (steady_clock::now() >= deadline) break;
    if (signal != 0) ::kill(process, signal);
    std::this_thread::sleep_for(milliseconds(2));
  }
  ::kill(process, SIGKILL);
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

// What a failed emulator said, with its own kind of error.
Error failure_of(const std::filesystem::path& program, int status, const std::string& said) {
  constexpr std::string_view kName = "tetragauge-emulator: ";
  std::string message = said.starts_with(kName) ? said.substr(kName.size()) : said;
  if (message.empty())
    message = program.string() + ": the emulator ended at once and said nothing; run it by hand";
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  switch (code) {
    case static_cast<int>(ErrorKind::usage):
      return usage_error(message);
    case static_cast<int>(ErrorKind::bad_input):
      return bad_input(message);
    default:
      return machine_error(message);
  }
}

}  // namespace

Result<std::unique_ptr<EmulatedMachine>> EmulatedMachine::start(const EmulatedMachineOptions& options) {
  const auto program = options.emulator.empty() ? beside_this_program() : options.emulator;
  if (::access(program.c_str(), X_OK) != 0) {
    return machine_error(program.string() + ": no emulator there; build the target tetragauge-emulator");
  }
  // Short, because a socket's path may have 107 characters only.
  std::string folder = "/tmp/tetragauge-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) {
    return machine_error("/tmp: cannot make a folder for the emulator's socket: " +
                         std::string(std::strerror(errno)));
  }
  std::unique_ptr<EmulatedMachine> machine(new EmulatedMachine);
  machine->folder_ = folder;
  machine->program_ = program;
  machine->device_ = "unix:" + folder + "/machine";

  std::vector<std::string> arguments{program.string(),
                                     "--board",
                                     options.board,
                                     "--part",
                                     options.part.string(),
                                     "--listen",
                                     machine->device_,
                                     "--seed",
                                     std::to_string(options.seed),
                                     "--speed",
                                     options.speed,
                                     "--own-folder"};
  if (options.one_host) arguments.push_back("--one-host");
  if (!options.place.empty()) arguments.push_back("--place=" + options.place);
  if (!options.world.empty()) arguments.push_back("--world=" + options.world.string());
  if (!options.faults.empty()) arguments.push_back("--faults=" + options.faults);
  if (!options.trace.empty()) arguments.push_back("--trace=" + options.trace.string());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  Pipe out, error;
  if (!out.open() || !error.open())
    return machine_error("no pipes for the emulator: " + std::string(std::strerror(errno)));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out.ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, error.ends[1], STDERR_FILENO);
  const int spawned =
      ::posix_spawn(&machine->process_, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (spawned != 0) {
    machine->process_ = -1;
    return machine_error(program.string() + ": cannot start: " + std::strerror(spawned));
  }
  out.close(1);
  error.close(1);
  machine->said_ = error.take(0);
  // The emulator prints its device once it listens.
  if (first_line(out.ends[0], options.start_timeout) == machine->device_) return machine;

  const int status = end_process(machine->process_);
  machine->process_ = -1;
  return failure_of(program, status, all_text(machine->said_));
}

std::optional<Error> EmulatedMachine::failure() {
  // One that has closed its line is on its way out; one that runs says nothing.
  int status = 0;
  pollfd last_word{said_, POLLIN, 0};
  if (process_ < 0 || ::poll(&last_word, 1, kLastWord_ms) <= 0) return std::nullopt;
  status = end_process(process_);
  process_ = -1;
  const std::string said = all_text(said_);
  if (said.empty() && WIFEXITED(status) && WEXITSTATUS(status) == 0) return std::nullopt;
  if (said.empty() && WIFSIGNALED(status))
    return machine_error(program_.string() + ": the emulator was ended by signal " +
                         std::to_string(WTERMSIG(status)));
  return failure_of(program_, status, said);
}

EmulatedMachine::~EmulatedMachine() {
  if (process_ > 0) end_process(process_);
  if (said_ >= 0) ::close(said_);
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace tetragauge
