// SPDX-License-Identifier: GPL-3.0-or-later
// Wall time per stage of the pipeline, for report.json's timing_s: the only key that may differ between two
// runs.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace tetragauge {

class StageTimer {
 public:
  // Ends the running stage, if any, and begins the next.
  void begin(std::string stage) {
    end();
    running_ = std::move(stage);
    start_ = std::chrono::steady_clock::now();
  }
  void end() {
    if (running_.empty()) return;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    stages_.emplace_back(std::exchange(running_, {}), elapsed.count());
  }
  const std::vector<std::pair<std::string, double>>& stages_s() const { return stages_; }

 private:
  std::string running_;
  std::chrono::steady_clock::time_point start_;
  std::vector<std::pair<std::string, double>> stages_;
};

}  // namespace tetragauge
