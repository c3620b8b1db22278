// SPDX-License-Identifier: GPL-3.0-or-later
// The terminal while a program draws on it: keys come at once, the screen is the program's own. However the
// program ends (return, error, signal, abort), the terminal is as it was before.
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "host/base/result.hpp"
#include "host/teach/key.hpp"

namespace tetragauge {

class RawTerminal {
 public:
  // Error (usage): standard input or output is no terminal. Only one may live at a time.
  static Status check();
  RawTerminal();
  ~RawTerminal();
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;

  // Keys that come within `timeout`. A terminal that has gone away counts as a wish to stop.
  std::vector<Key> read(std::chrono::milliseconds timeout);
  // Lines from the top; only those that changed are sent.
  void draw(const std::vector<std::string>& lines);
  // Gives the terminal back, stops as a shell expects of Ctrl-Z, and takes it again when resumed.
  void suspend();

  // Columns and rows; a change makes the next draw() complete.
  size_t columns() const { return columns_; }
  size_t rows() const { return rows_; }

  // SIGTERM, SIGHUP or SIGINT came, or the terminal is gone.
  static const std::atomic<bool>& stop_asked();

 private:
  void enter();
  void leave();
  void measure();

  KeyDecoder decoder_;
  std::vector<std::string> shown_;
  size_t columns_ = 80, rows_ = 24;
};

}  // namespace tetragauge
