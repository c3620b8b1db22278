// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an386/qemu_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>

#include "boards/mps2_an386/bus.hpp"

namespace tetragauge {
namespace {

constexpr const char* kProgram = "qemu-system-arm";
constexpr const char* kSaid = "said";  // what QEMU and the image print
// A turn takes some 50 us. Only a QEMU that hangs takes so long, on a computer however busy.
constexpr std::chrono::seconds kPatience{120};
constexpr int kWaitSlice_ms = 200;

std::string error_text() {
  return std::strerror(errno);
}

// Of the child, between fork and exec. What keeps it from becoming QEMU goes into `failed`, which exec
// closes.
[[noreturn]] void become_qemu(const std::string& folder, const std::string& image, pid_t parent, int failed) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Ctrl-C at the terminal is for the program that started this one.
  ::setpgid(0, 0);
  if (::getppid() == parent && ::chdir(folder.c_str()) == 0) {
    const int said = ::open(kSaid, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(said, STDOUT_FILENO);
    ::dup2(said, STDERR_FILENO);
    // An instruction takes 8 ns of virtual time, always: the image's own clock is exact.
    ::execlp(kProgram, kProgram, "-M", "mps2-an386", "-display", "none", "-monitor", "none", "-serial",
             "none", "-icount", "shift=3,sleep=off", "-semihosting-config", "enable=on,target=native",
             "-kernel", image.c_str(), nullptr);
  }
  const int why = errno;
  if (::write(failed, &why, sizeof why) < 0) ::_exit(126);
  ::_exit(127);
}

}  // namespace

Result<std::unique_ptr<QemuProcess>> QemuProcess::start(const std::filesystem::path& image) {
  std::error_code failed;
  const std::filesystem::path absolute = std::filesystem::absolute(image, failed);
  if (!std::filesystem::is_regular_file(absolute, failed)) {
    return machine_error(
        "--board mps2_an386: its image " + absolute.string() +
        " is not there; run script/setup, which installs arm-none-eabi-g++, and script/build");
  }
  std::string folder = "/tmp/tetragauge-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr)
    return machine_error("/tmp: cannot make a folder for QEMU: " + error_text());
  std::unique_ptr<QemuProcess> qemu(new QemuProcess);
  qemu->folder_ = folder;
  const std::string to_image = folder + "/" + mps2_bus::kToImage,
                    to_world = folder + "/" + mps2_bus::kToWorld;
  if (::mkfifo(to_image.c_str(), 0600) != 0 || ::mkfifo(to_world.c_str(), 0600) != 0)
    return machine_error(folder + ": cannot make FIFOs for QEMU: " + error_text());
  // For both ways, so that opening does not wait for QEMU. What QEMU's end tells is that of the other one.
  qemu->to_image_ = ::open(to_image.c_str(), O_RDWR | O_CLOEXEC);
  qemu->to_world_ = ::open(to_world.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (qemu->to_image_ < 0 || qemu->to_world_ < 0)
    return machine_error(folder + ": cannot open the FIFOs to QEMU: " + error_text());
  int failed_to_run[2];
  if (::pipe2(failed_to_run, O_CLOEXEC) != 0)
    return machine_error("no pipe for starting QEMU: " + error_text());
  const pid_t parent = ::getpid();
  qemu->process_ = ::fork();
  if (qemu->process_ == 0) become_qemu(folder, absolute.string(), parent, failed_to_run[1]);
  ::close(failed_to_run[1]);
  int why = 0;
  if (qemu->process_ < 0) {
    why = errno;
  } else {
    while (::read(failed_to_run[0], &why, sizeof why) < 0 && errno == EINTR) {
    }
  }
  ::close(failed_to_run[0]);
  if (why == ENOENT) {
    return machine_error(std::string("--board mps2_an386: ") + kProgram +
                         " is not installed; run script/setup, or install Debian's package qemu-system-arm");
  }
  if (why != 0) return machine_error(std::string(kProgram) + ": cannot be run: " + std::strerror(why));
  return qemu;
}

QemuProcess::~QemuProcess() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);  // in a read of the FIFO it hears nothing else
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  if (to_image_ >= 0) ::close(to_image_);
  if (to_world_ >= 0) ::close(to_world_);
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

Error QemuProcess::failure(const std::string& what) {
  std::ifstream file(folder_ / kSaid);
  std::string said((std::istreambuf_iterator<char>(file)), {});
  while (!said.empty() && said.back() == '\n') said.pop_back();
  return machine_error("--board mps2_an386: " + what + (said.empty() ? "" : "; it said: " + said));
}

Status QemuProcess::send(const void* bytes, size_t count) {
  // Less than a FIFO holds, and the image has read all before it: never waits.
  const ssize_t written = ::write(to_image_, bytes, count);
  if (written == static_cast<ssize_t>(count)) return Done{};
  return failure("cannot write to QEMU: " + error_text());
}

Status QemuProcess::receive(void* bytes, size_t count) {
  auto* at = static_cast<char*>(bytes);
  auto patience_ends = std::chrono::steady_clock::now() + kPatience;
  while (count > 0) {
    const ssize_t got = ::read(to_world_, at, count);
    if (got > 0) {
      at += got;
      count -= static_cast<size_t>(got);
      continue;
    }
    // Nothing there yet, or nobody at the other end: not yet at the start, no longer when it has ended.
    int status = 0;
    if (got == 0 || errno != EAGAIN) {
      if (::waitpid(process_, &status, WNOHANG) == process_) {
        process_ = -1;
        if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
          return machine_error(
              std::string("--board mps2_an386: ") + kProgram +
              " is not installed; run script/setup, or install Debian's package qemu-system-arm");
        }
        if (WIFSIGNALED(status))
          return failure("QEMU was ended by signal " + std::to_string(WTERMSIG(status)));
        return failure("QEMU has ended with code " + std::to_string(WEXITSTATUS(status)));
      }
    }
    if (std::chrono::steady_clock::now() >= patience_ends)
      return failure("the image in QEMU has not answered for " + std::to_string(kPatience.count()) + " s");
    pollfd waiting{to_world_, POLLIN, 0};
    // Without a writer there is nothing to wait for but time.
    ::poll(&waiting, 1, kWaitSlice_ms);
    if ((waiting.revents & POLLHUP) != 0 && (waiting.revents & POLLIN) == 0) ::usleep(1000);
  }
  return Done{};
}

}  // namespace tetragauge
