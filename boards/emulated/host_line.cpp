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

namespace tetragauge {
namespace {

void make_nonblocking(int fd) {
  ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
}

}  // namespace

HostLine::HostLine(const Descriptors& descriptors)
    : listener_fd_(descriptors.listener_fd), fd_(descriptors.fd), one_host_(descriptors.one_host) {
  if (fd_ >= 0) make_nonblocking(fd_);
}

HostLine::~HostLine() {
  if (fd_ >= 0) ::close(fd_);
  if (listener_fd_ >= 0) ::close(listener_fd_);
}

void HostLine::host_gone() {
  received_.clear();
  if (one_host_ || listener_fd_ < 0) {
    closed_ = true;
    return;
  }
  ::close(fd_);
  fd_ = -1;
}

bool HostLine::wait_for_bytes(int timeout_ms) {
  if (closed_) return false;
  pollfd waiting{fd_ >= 0 ? fd_ : listener_fd_, POLLIN, 0};
  if (::poll(&waiting, 1, timeout_ms) <= 0) return false;
  if (fd_ < 0) {
    fd_ = ::accept4(listener_fd_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    const int on = 1;  // small frames must not wait for one another; only TCP knows the option
    if (fd_ >= 0) ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return false;
  }
  uint8_t buffer[4096];
  const ssize_t count = ::read(fd_, buffer, sizeof buffer);
  if (count > 0) {
    received_.insert(received_.end(), buffer, buffer + count);
    return true;
  }
  // 0: a socket was closed. EIO: the last one who had the pseudo-terminal open has closed it.
  if (count == 0 || (errno != EAGAIN && errno != EINTR)) host_gone();
  return false;
}

size_t HostLine::read(uint8_t* bytes, size_t capacity) {
  const size_t count = std::min(capacity, received_.size());
  std::copy_n(received_.begin(), count, bytes);
  received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(count));
  return count;
}

size_t HostLine::write(const uint8_t* bytes, size_t count) {
  if (fd_ < 0 || closed_) return count;
  const ssize_t written = ::write(fd_, bytes, count);
  if (written >= 0) return static_cast<size_t>(written);
  if (errno == EAGAIN || errno == EINTR) return 0;
  host_gone();
  return count;
}

}  // namespace tetragauge
