// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/link/socket_transport.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace tetragauge {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

int remaining_ms(steady_clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now()).count();
  return left > 0 ? static_cast<int>(left) : 0;
}

class SocketTransport final : public Transport {
 public:
  SocketTransport(int fd, std::string device) : fd_(fd), device_(std::move(device)) {}
  ~SocketTransport() override { ::close(fd_); }

  Result<size_t> read_some(std::span<uint8_t> buffer, milliseconds timeout) override {
    const auto deadline = steady_clock::now() + timeout;
    for (;;) {
      const ssize_t n = ::recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (n > 0) return static_cast<size_t>(n);
      if (n == 0) return gone("closed by the other side");
      if (errno == EINTR) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) return gone(std::strerror(errno));
      pollfd waiting{fd_, POLLIN, 0};
      const int ready = ::poll(&waiting, 1, remaining_ms(deadline));
      if (ready == 0) return size_t{0};
      if (ready < 0 && errno == EINTR) return size_t{0};
    }
  }

  Status write_all(std::span<const uint8_t> bytes, milliseconds timeout) override {
    const auto deadline = steady_clock::now() + timeout;
    while (!bytes.empty()) {
      const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (n > 0) {
        bytes = bytes.subspan(static_cast<size_t>(n));
        continue;
      }
      if (errno == EINTR) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) return gone(std::strerror(errno));
      pollfd waiting{fd_, POLLOUT, 0};
      if (::poll(&waiting, 1, remaining_ms(deadline)) == 0) {
        return machine_error(device_ +
                             ": the other side takes no bytes; is the machine stopped in a debugger?");
      }
    }
    return Done{};
  }

  const std::string& device() const override { return device_; }

 private:
  Error gone(const std::string& why) const {
    return machine_error(device_ + ": the connection ended (" + why +
                         "); see whether the emulator or the network serial server still runs, start it "
                         "again and repeat the command");
  }

  int fd_;
  std::string device_;
};

// connect() bounded in time: the socket is non-blocking from here on.
bool connect_within(int fd, const sockaddr* address, socklen_t size, milliseconds timeout) {
  ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
  if (::connect(fd, address, size) == 0) return true;
  if (errno != EINPROGRESS) return false;
  pollfd waiting{fd, POLLOUT, 0};
  if (::poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) {
    errno = ETIMEDOUT;
    return false;
  }
  int failure = 0;
  socklen_t length = sizeof failure;
  ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &failure, &length);
  errno = failure;
  return failure == 0;
}

}  // namespace

Result<std::unique_ptr<Transport>> open_unix_transport(const std::string& device,
                                                       const TransportOptions& options) {
  const std::string path = device.substr(std::strlen("unix:"));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return usage_error(device + ": a unix socket's path has 1 to " +
                       std::to_string(sizeof address.sun_path - 1) + " characters");
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return machine_error(device + ": no socket: " + std::strerror(errno));
  if (!connect_within(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address,
                      options.connect_timeout)) {
    const int failure = errno;
    ::close(fd);
    switch (failure) {
      case ENOENT:
        return machine_error(device + ": no such socket; start the emulator with --listen " + device);
      case EACCES:
        return machine_error(device + ": no permission; the emulator runs as another user");
      case ECONNREFUSED:
        return machine_error(
            device + ": nobody listens there any more; start the emulator again with --listen " + device);
      default:
        return machine_error(device + ": cannot connect: " + std::strerror(failure));
    }
  }
  return std::unique_ptr<Transport>(std::make_unique<SocketTransport>(fd, device));
}

Result<std::unique_ptr<Transport>> open_tcp_transport(const std::string& device,
                                                      const TransportOptions& options) {
  const std::string rest = device.substr(std::strlen("tcp:"));
  const size_t colon = rest.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == rest.size()) {
    return usage_error(device + ": a network device is written tcp:HOST:PORT");
  }
  const std::string host = rest.substr(0, colon), port = rest.substr(colon + 1);
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int failure = ::getaddrinfo(host.c_str(), port.c_str(), &wanted, &found); failure != 0) {
    return machine_error(device + ": " + ::gai_strerror(failure) + "; check host name and port");
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
  int failure = 0;
  for (const addrinfo* a = found; a != nullptr; a = a->ai_next) {
    const int fd = ::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
    if (fd < 0) continue;
    if (connect_within(fd, a->ai_addr, a->ai_addrlen, options.connect_timeout)) {
      const int on = 1;  // small frames must not wait for one another
      ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return std::unique_ptr<Transport>(std::make_unique<SocketTransport>(fd, device));
    }
    failure = errno;
    ::close(fd);
  }
  return machine_error(device + ": cannot connect: " + std::strerror(failure) +
                       "; see whether the emulator, QEMU or serial server listens on that port");
}

}  // namespace tetragauge
