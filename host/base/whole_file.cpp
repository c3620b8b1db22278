// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/whole_file.hpp"

#include <fcntl.h>
#include <openssl/sha.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace tetragauge {
namespace {

Error errno_error(const std::string& what, const std::filesystem::path& path) {
  const int code = errno;
  return bad_input(what + " " + path.string() + ": " + std::strerror(code));
}

std::string kind_of(std::filesystem::file_type type) {
  switch (type) {
    case std::filesystem::file_type::directory:
      return "a folder";
    case std::filesystem::file_type::fifo:
      return "a pipe";
    case std::filesystem::file_type::socket:
      return "a socket";
    default:
      return "a device";
  }
}

}  // namespace

Result<std::string> read_whole_file(const std::filesystem::path& path) {
  std::error_code status_error;
  if (std::filesystem::is_directory(path, status_error)) {
    return bad_input("cannot read " + path.string() + ": it is a folder; name a file in it");
  }
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return errno_error("cannot read", path);
  std::string content;
  std::array<char, 1 << 16> block;
  for (;;) {
    const ssize_t got = ::read(fd, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      Error error = errno_error("cannot read", path);
      ::close(fd);
      return error;
    }
    if (got == 0) break;
    content.append(block.data(), static_cast<size_t>(got));
  }
  ::close(fd);
  return content;
}

Result<std::filesystem::path> file_to_replace(const std::filesystem::path& path) {
  constexpr int kMostLinks = 40;  // as Linux itself
  std::filesystem::path file = path;
  std::error_code error;
  for (int links = 0; std::filesystem::is_symlink(std::filesystem::symlink_status(file, error)); ++links) {
    const std::filesystem::path target = std::filesystem::read_symlink(file, error);
    if (error || links == kMostLinks) {
      return bad_input("cannot write " + path.string() + ": its symbolic links lead nowhere; name a file");
    }
    file = file.parent_path() / target;  // an absolute target replaces the folder
  }
  // Asked of `path`: the links of /proc/self/fd do not say what they lead to.
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return bad_input("cannot write " + path.string() + ": it is " + kind_of(status.type()) +
                     ", not a regular file; name a file");
  }
  return file;
}

Status write_whole_file(const std::filesystem::path& path, std::string_view content) {
  const Result<std::filesystem::path> file = file_to_replace(path);
  if (!file) return file.error();
  const std::filesystem::path temporary = file->string() + ".part" + std::to_string(::getpid());
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return errno_error("cannot write", path);
  const auto fail = [&]() -> Status {
    Error error = errno_error("cannot write", path);
    ::close(fd);
    ::unlink(temporary.c_str());
    return error;
  };
  while (!content.empty()) {
    const ssize_t put = ::write(fd, content.data(), content.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return fail();
    content.remove_prefix(static_cast<size_t>(put));
  }
  if (::fsync(fd) != 0 && errno != EINVAL) return fail();
  if (::close(fd) != 0 || ::rename(temporary.c_str(), file->c_str()) != 0) {
    Error error = errno_error("cannot write", path);
    ::unlink(temporary.c_str());
    return error;
  }
  return Done{};
}

std::string sha256_hex(std::string_view content) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest;
  SHA256(reinterpret_cast<const unsigned char*>(content.data()), content.size(), digest.data());
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : digest) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

}  // namespace tetragauge
