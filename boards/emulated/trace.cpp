// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/trace.hpp"

#include <cerrno>
#include <cinttypes>
#include <cstring>
#include <utility>

#include "protocol/state_name.hpp"

namespace tetragauge {
namespace {

constexpr const char* kFaults[] = {"NONE",     "INTERLOCK",    "MIRROR",         "SIGNAL",
                                   "LASER",    "LIMIT",        "HOME_NOT_FOUND", "HOME_STUCK",
                                   "SAMPLING", "MISASSEMBLED", "STORAGE"};
static_assert(std::size(kFaults) == _tg_FaultCode_ARRAYSIZE);

}  // namespace

Result<std::unique_ptr<Trace>> Trace::open(const std::string& path) {
  auto trace = std::make_unique<Trace>();
  trace->path_ = path;
  trace->file_.reset(std::fopen(path.c_str(), "we"));
  if (!trace->file_) {
    return usage_error("--trace " + path + ": cannot be written: " + std::strerror(errno) +
                       "; choose a file in a folder that you may write to");
  }
  std::fputs("time_ns,what,value\n", trace->file_.get());
  return trace;
}

void Trace::line(uint64_t now_ns, const char* what, const char* value) {
  std::fprintf(file_.get(), "%" PRIu64 ",%s,%s\n", now_ns, what, value);
}

void Trace::machine(uint64_t now_ns, const Seen& seen) {
  if (seen.fault != last_.fault) line(now_ns, "fault", kFaults[seen.fault]);
  if (seen.state != last_.state) line(now_ns, "state", state_name(seen.state));
  if (seen.view != last_.view && seen.view != 0) line(now_ns, "view", std::to_string(seen.view).c_str());
  last_ = seen;
}

void Trace::laser(uint64_t now_ns, bool on) {
  if (std::exchange(laser_on_, on) != on) line(now_ns, "laser", on ? "on" : "off");
}

Status Trace::close() {
  const bool good = std::ferror(file_.get()) == 0 && std::fclose(file_.release()) == 0;
  if (!good) return machine_error("--trace " + path_ + ": not all of it could be written; is the disk full?");
  return Done{};
}

}  // namespace tetragauge
