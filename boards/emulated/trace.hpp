// SPDX-License-Identifier: Apache-2.0
// What the machine did and when, one line for each change, as comma-separated values:
//
//   time_ns,what,value
//   1834000000,state,SCANNING
//   1834560000,laser,on
//
// what: state, fault (protocol/machine.proto's names), laser (on, off), view (from 1). Time is virtual, from
// power-on. The same commands to the same machine give the same bytes.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "host/base/result.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

class Trace {
 public:
  // A regular file is replaced.
  static Result<std::unique_ptr<Trace>> open(const std::string& path);

  struct Seen {
    tg_State state = tg_State_STATE_BOOT;
    tg_FaultCode fault = tg_FaultCode_FAULT_NONE;
    uint32_t view = 0;  // 0: none
  };
  void machine(uint64_t now_ns, const Seen& seen);
  void laser(uint64_t now_ns, bool on);
  // Error: not everything could be written.
  Status close();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void line(uint64_t now_ns, const char* what, const char* value);

  std::string path_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  Seen last_;
  bool laser_on_ = false;
};

}  // namespace tetragauge
