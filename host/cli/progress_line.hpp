// SPDX-License-Identifier: GPL-3.0-or-later
// One line on the terminal that says how far a scan is; nothing when stderr is no terminal or with --quiet.
#pragma once

#include <chrono>
#include <string>

#include "host/session/run_scan.hpp"

namespace tetragauge::cli {

// "view 3 of 8, 5210 points, 302 beams/s, 1:20 left, rejected 12 weak, 4 ambient"; `elapsed_s` since the
// first beam of this session.
std::string progress_text(const ScanProgress& progress, double elapsed_s);
// "12 weak, 4 ambient"; empty when none were.
std::string rejected_text(const ScanCounts& counts);
// A RejectReason in a word; empty when there is none of that number.
const char* reject_word(size_t reason);

class ProgressLine {
 public:
  explicit ProgressLine(bool shown) : shown_(shown) {}
  ~ProgressLine() { end(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const ScanProgress& progress);
  // Before anything else is printed.
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  bool shown_;
  bool survey_ = false;
  size_t length_ = 0;  // of the text that stands there
  Clock::time_point start_, drawn_;
};

}  // namespace tetragauge::cli
