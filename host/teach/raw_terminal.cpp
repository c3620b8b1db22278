// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/raw_terminal.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>

namespace tetragauge {
namespace {

// Alternate screen and no cursor; and back, with colours off.
constexpr std::string_view kEnter = "\x1b[?1049h\x1b[?25l\x1b[2J", kLeave = "\x1b[0m\x1b[?25h\x1b[?1049l";
constexpr std::array kEndings{SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGQUIT};
constexpr std::array kRequests{SIGTERM, SIGHUP, SIGINT};

// For signal handlers, which know no object.
termios terminal_before;
volatile sig_atomic_t is_raw = 0;
std::atomic<bool> stop{false}, resized{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");
std::array<struct sigaction, 8> actions_before;
struct sigaction resize_before;

void put(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // gone; read() notices
    text.remove_prefix(static_cast<size_t>(written));
  }
}

// write() and tcsetattr() may be called from a signal handler.
void give_back() {
  if (!is_raw) return;
  is_raw = 0;
  put(kLeave);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &terminal_before);
}

void end_at_once(int signal) {
  give_back();
  ::raise(signal);  // SA_RESETHAND: as if nobody had caught it
}

void install(int signal, void (*handler)(int), int flags, struct sigaction* before) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  ::sigaction(signal, &action, before);
}

}  // namespace

Status RawTerminal::check() {
  if (::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0) return Done{};
  return usage_error("teach needs a terminal for its keys and pictures; run it in one, not in a pipe");
}

const std::atomic<bool>& RawTerminal::stop_asked() {
  return stop;
}

RawTerminal::RawTerminal() {
  stop = false;
  ::tcgetattr(STDIN_FILENO, &terminal_before);
  size_t k = 0;
  for (const int signal : kRequests)
    install(
        signal, [](int) { stop = true; }, 0, &actions_before[k++]);
  struct sigaction unused {};
  for (const int signal : kEndings) install(signal, end_at_once, static_cast<int>(SA_RESETHAND), &unused);
  install(
      SIGWINCH, [](int) { resized = true; }, 0, &resize_before);
  enter();
}

RawTerminal::~RawTerminal() {
  leave();
  size_t k = 0;
  for (const int signal : kRequests) ::sigaction(signal, &actions_before[k++], nullptr);
  for (const int signal : kEndings) ::signal(signal, SIG_DFL);
  ::sigaction(SIGWINCH, &resize_before, nullptr);
}

void RawTerminal::enter() {
  termios raw = terminal_before;
  raw.c_iflag &= ~static_cast<tcflag_t>(BRKINT | ICRNL | INPCK | ISTRIP | IXON);
  // ISIG: Ctrl-C and Ctrl-Z are keys. Signals that others send come all the same.
  raw.c_lflag &= ~static_cast<tcflag_t>(ECHO | ICANON | IEXTEN | ISIG);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  is_raw = 1;
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &raw);
  put(kEnter);
  measure();
}

void RawTerminal::leave() {
  give_back();
}

void RawTerminal::measure() {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0) {
    columns_ = size.ws_col;
    rows_ = size.ws_row;
  }
  shown_.clear();
}

std::vector<Key> RawTerminal::read(std::chrono::milliseconds timeout) {
  if (resized.exchange(false)) {
    put("\x1b[2J");
    measure();
  }
  pollfd waiting{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  const int ready = ::poll(&waiting, 1, static_cast<int>(timeout.count()));
  if (ready == 0) return decoder_.rest();
  if (ready < 0) return {};  // a signal
  std::array<char, 256> bytes;
  const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return {};
  if (count <= 0) {
    stop = true;
    return {};
  }
  return decoder_.take({bytes.data(), static_cast<size_t>(count)});
}

void RawTerminal::draw(const std::vector<std::string>& lines) {
  std::string out;
  for (size_t k = 0; k < lines.size(); ++k) {
    if (k < shown_.size() && shown_[k] == lines[k]) continue;
    out += "\x1b[" + std::to_string(k + 1) + ";1H" + lines[k] + "\x1b[0m\x1b[K";
  }
  shown_ = lines;
  if (!out.empty()) put(out);
}

void RawTerminal::suspend() {
  leave();
  ::raise(SIGTSTP);
  enter();
}

}  // namespace tetragauge
