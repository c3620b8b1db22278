// SPDX-License-Identifier: GPL-3.0-or-later
// Lets libserialport 0.1.1 open a pseudo-terminal, so that its path through our code runs in tests without a
// serial port: LD_PRELOAD this library and open /dev/pts/N as the port. The library asks for two things that
// a pty lacks: an entry below /sys/class/tty (lstat and readlink) and modem lines (ioctl TIOCMGET, TIOCMSET).
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/types.h>

static const char kPtyEntry[] = "/sys/class/tty/pts/";
static const char kLinkTarget[] = "../../devices/virtual/tty/pts";

static int is_pty_entry(const char* path) {
  return path != NULL && strncmp(path, kPtyEntry, sizeof kPtyEntry - 1) == 0;
}

// Unix 98 pty slaves have the majors 136 to 143 (Linux, Documentation/admin-guide/devices.txt).
static int is_pty(int fd) {
  struct stat info;
  return fstat(fd, &info) == 0 && S_ISCHR(info.st_mode) && major(info.st_rdev) >= 136 &&
         major(info.st_rdev) <= 143;
}

static void fill_link(struct stat* info) {
  memset(info, 0, sizeof *info);
  info->st_mode = S_IFLNK | 0777;
}

int lstat(const char* restrict path, struct stat* restrict info) {
  static int (*next)(const char*, struct stat*);
  if (is_pty_entry(path)) {
    fill_link(info);
    return 0;
  }
  if (next == NULL) next = (int (*)(const char*, struct stat*))dlsym(RTLD_NEXT, "lstat");
  return next(path, info);
}

// What lstat() becomes in a library built against glibc before 2.33, as Debian's libserialport is.
int __lxstat(int version, const char* path, struct stat* info) {
  static int (*next)(int, const char*, struct stat*);
  if (is_pty_entry(path)) {
    fill_link(info);
    return 0;
  }
  if (next == NULL) next = (int (*)(int, const char*, struct stat*))dlsym(RTLD_NEXT, "__lxstat");
  return next(version, path, info);
}

static ssize_t read_link(const char* path, char* target, size_t size) {
  static ssize_t (*next)(const char*, char*, size_t);
  if (is_pty_entry(path)) {
    const size_t length = sizeof kLinkTarget - 1 < size ? sizeof kLinkTarget - 1 : size;
    memcpy(target, kLinkTarget, length);
    return (ssize_t)length;
  }
  if (next == NULL) next = (ssize_t(*)(const char*, char*, size_t))dlsym(RTLD_NEXT, "readlink");
  return next(path, target, size);
}

ssize_t readlink(const char* restrict path, char* restrict target, size_t size) {
  return read_link(path, target, size);
}

// What readlink() becomes in a library built with _FORTIFY_SOURCE, as Debian's are.
ssize_t __readlink_chk(const char* path, char* target, size_t size, size_t room) {
  return read_link(path, target, size < room ? size : room);
}

int ioctl(int fd, unsigned long request, ...) {
  static int (*next)(int, unsigned long, ...);
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (request == TIOCMGET && is_pty(fd)) {
    *(int*)argument = TIOCM_DTR | TIOCM_RTS;
    return 0;
  }
  if ((request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC) && is_pty(fd)) return 0;
  if (next == NULL) next = (int (*)(int, unsigned long, ...))dlsym(RTLD_NEXT, "ioctl");
  return next(fd, request, argument);
}
