// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/host_line.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "sim/noise.hpp"

namespace tetragauge {
namespace {

void make_nonblocking(int fd) {
  ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
}

}  // namespace

HostLine::HostLine(const Descriptors& descriptors, const sim::Faults& faults)
    : listener_fd_(descriptors.listener_fd),
      fd_(descriptors.fd),
      one_host_(descriptors.one_host),
      cuts_(faults.line_cut),
      to_board_(faults.to_machine, faults.line_cut, sim::combine_key(faults.seed, 1)),
      to_host_(faults.to_host, faults.line_cut, sim::combine_key(faults.seed, 2)) {
  if (fd_ >= 0) make_nonblocking(fd_);
}

HostLine::~HostLine() {
  if (fd_ >= 0) ::close(fd_);
  if (listener_fd_ >= 0) ::close(listener_fd_);
}

void HostLine::host_gone() {
  to_board_.clear();
  to_host_.clear();
  outbox_.clear();
  debts_.another_host();
  if (one_host_ || listener_fd_ < 0) {
    closed_ = true;
    return;
  }
  ::close(fd_);
  fd_ = -1;
}

bool HostLine::wait_for_bytes(int timeout_ms, uint64_t now_ns) {
  if (closed_) return false;
  const short what = host_reads_too_slowly() ? POLLIN | POLLOUT : POLLIN;
  pollfd waiting{fd_ >= 0 ? fd_ : listener_fd_, what, 0};
  if (::poll(&waiting, 1, timeout_ms) <= 0) return false;
  if (fd_ < 0) {
    fd_ = ::accept4(listener_fd_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    const int on = 1;  // small frames must not wait for one another; only TCP knows the option
    if (fd_ >= 0) ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return false;
  }
  if ((waiting.revents & POLLOUT) != 0) flush();
  if ((waiting.revents & ~POLLOUT) == 0) return false;
  uint8_t buffer[4096];
  const ssize_t count = ::read(fd_, buffer, sizeof buffer);
  if (count > 0) {
    debts_.host_said({buffer, static_cast<size_t>(count)});
    for (ssize_t i = 0; i < count; ++i) to_board_.send(buffer[i], now_ns);
    return true;
  }
  // 0: a socket was closed. EIO: the last one who had the pseudo-terminal open has closed it.
  if (count == 0 || (errno != EAGAIN && errno != EINTR)) host_gone();
  return false;
}

size_t HostLine::read(uint8_t* bytes, size_t capacity, uint64_t now_ns) {
  size_t count = 0;
  while (count < capacity) {
    const auto arrival = to_board_.take(now_ns);
    if (!arrival) break;
    if (arrival->byte) bytes[count++] = *arrival->byte;
  }
  return count;
}

size_t HostLine::write(const uint8_t* bytes, size_t count, uint64_t now_ns) {
  if (!connected()) return count;
  if (host_reads_too_slowly()) return 0;
  for (size_t i = 0; i < count; ++i) to_host_.send(bytes[i], now_ns);
  deliver(now_ns);
  return count;
}

void HostLine::deliver(uint64_t now_ns) {
  while (const auto arrival = to_host_.take(now_ns)) {
    if (arrival->byte) {
      outbox_.push_back(*arrival->byte);
      debts_.reached_host(*arrival->byte);
    }
    if (arrival->frame_end) debts_.frame_ended();
  }
  flush();
}

void HostLine::flush() {
  while (connected() && !outbox_.empty()) {
    const ssize_t written = ::write(fd_, outbox_.data(), outbox_.size());
    if (written > 0) {
      outbox_.erase(outbox_.begin(), outbox_.begin() + written);
    } else {
      if (errno != EAGAIN && errno != EINTR) host_gone();
      return;
    }
  }
}

uint64_t HostLine::next_event_ns(uint64_t now_ns) const {
  uint64_t next = std::min(to_board_.next_due_ns(), to_host_.next_due_ns());
  for (const sim::TimeSpan& cut : cuts_) {
    if (cut.holds(static_cast<int64_t>(now_ns))) next = std::min(next, static_cast<uint64_t>(cut.until_ns));
  }
  return next;
}

}  // namespace tetragauge
