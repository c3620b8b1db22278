// SPDX-License-Identifier: Apache-2.0
// QEMU with an image for the mps2-an386, on two FIFOs in a folder of its own. It ends with this object, or
// with this program, whatever happens to either.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "host/base/result.hpp"

namespace tetragauge {

class QemuProcess {
 public:
  // Errors say what to install or to build.
  static Result<std::unique_ptr<QemuProcess>> start(const std::filesystem::path& image);
  ~QemuProcess();
  QemuProcess(const QemuProcess&) = delete;
  QemuProcess& operator=(const QemuProcess&) = delete;

  // Errors of both: QEMU has ended or hangs, with what it said.
  Status send(const void* bytes, size_t count);
  Status receive(void* bytes, size_t count);

 private:
  QemuProcess() = default;
  Error failure(const std::string& what);

  std::filesystem::path folder_;
  pid_t process_ = -1;
  int to_image_ = -1, to_world_ = -1;
};

}  // namespace tetragauge
