// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/listen.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

namespace tetragauge {
namespace {

Error failed(const std::string& where, const std::string& what) {
  return machine_error("--listen " + where + ": " + what + ": " + std::strerror(errno));
}

Result<Listening> listen_unix(const std::string& where) {
  const std::string path = where.substr(std::strlen("unix:"));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return usage_error("--listen " + where + ": a unix socket's path has 1 to " +
                       std::to_string(sizeof address.sun_path - 1) + " characters; give a shorter one");
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const auto* raw = reinterpret_cast<const sockaddr*>(&address);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return failed(where, "no socket");
  bool bound = ::bind(fd, raw, sizeof address) == 0;
  if (!bound && errno == EADDRINUSE) {
    if (::connect(fd, raw, sizeof address) == 0) {
      ::close(fd);
      return machine_error("--listen " + where +
                           ": another emulator listens there; end it or choose another path");
    }
    ::unlink(path.c_str());
    bound = ::bind(fd, raw, sizeof address) == 0;
  }
  if (!bound) return failed(where, "cannot make the socket");
  if (::listen(fd, 1) != 0) return failed(where, "cannot listen");
  return Listening{.listener_fd = fd, .device = where, .socket_path = path};
}

Result<Listening> listen_tcp(const std::string& where) {
  const std::string text = where.substr(std::strlen("tcp:"));
  uint16_t port = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (failure != std::errc() || end != text.data() + text.size()) {
    return usage_error("--listen " + where + ": the port is a number from 0 (any free one) to 65535");
  }
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return failed(where, "no socket");
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  socklen_t size = sizeof address;
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), size) != 0 || ::listen(fd, 1) != 0 ||
      ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return failed(where, "cannot listen on that port");
  }
  return Listening{.listener_fd = fd, .device = "tcp:localhost:" + std::to_string(ntohs(address.sin_port))};
}

Result<Listening> open_pty() {
  const int fd = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (fd < 0 || ::grantpt(fd) != 0 || ::unlockpt(fd) != 0) return failed("pty", "no pseudo-terminal");
  char name[64];
  if (::ptsname_r(fd, name, sizeof name) != 0) return failed("pty", "no name of the pseudo-terminal");
  // Raw from the start, so that nothing of a host's first bytes is echoed or changed.
  termios mode{};
  ::tcgetattr(fd, &mode);
  ::cfmakeraw(&mode);
  ::tcsetattr(fd, TCSANOW, &mode);
  return Listening{.fd = fd, .device = name};
}

}  // namespace

Result<Listening> start_listening(const std::string& where) {
  if (where.starts_with("unix:")) return listen_unix(where);
  if (where.starts_with("tcp:")) return listen_tcp(where);
  if (where == "pty") return open_pty();
  return usage_error("--listen " + where + ": must be unix:PATH, tcp:PORT or pty");
}

}  // namespace tetragauge
