// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/progress_line.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

namespace tetragauge::cli {
namespace {

constexpr std::chrono::milliseconds kRedraw{100};

std::string time_text(double seconds) {
  const long whole = static_cast<long>(seconds + 0.5);
  char text[40];
  if (whole >= 3600) {
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
  } else {
    std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  }
  return text;
}

}  // namespace

const char* reject_word(size_t reason) {
  // By RejectReason (protocol/machine.proto).
  constexpr std::array<const char*, 6> kWords{"",        "weak",         "saturated",
                                              "ambient", "inconsistent", "outside the volume"};
  return reason < kWords.size() ? kWords[reason] : "";
}

std::string rejected_text(const ScanCounts& counts) {
  std::string text;
  for (size_t reason = 1; reason < counts.rejected.size(); ++reason) {
    if (counts.rejected[reason] == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(counts.rejected[reason]) + " " + reject_word(reason);
  }
  return text;
}

std::string progress_text(const ScanProgress& progress, double elapsed_s) {
  const ScanCounts& counts = progress.counts;
  std::string text = progress.survey ? "survey: " : "";
  text += "view " + std::to_string(progress.view) + " of " + std::to_string(progress.views) + ", " +
          std::to_string(counts.points) + " points";
  const std::string rejected = rejected_text(counts);
  const double beams = static_cast<double>(counts.beams - progress.beams_resumed);
  if (elapsed_s > 0.5 && beams > 0) {
    const double rate = beams / elapsed_s;
    char number[40];
    std::snprintf(number, sizeof number, ", %.0f beams/s", rate);
    text += number;
    if (progress.beams_planned >= counts.beams)
      text += ", " + time_text(static_cast<double>(progress.beams_planned - counts.beams) / rate) + " left";
  }
  if (!rejected.empty()) text += ", rejected " + rejected;
  return text;
}

void ProgressLine::show(const ScanProgress& progress) {
  if (!shown_) return;
  const auto now = Clock::now();
  if (length_ == 0 || progress.survey != survey_) {
    end();
    survey_ = progress.survey;
    start_ = now;
  } else if (now - drawn_ < kRedraw) {
    return;
  }
  drawn_ = now;
  std::string text = progress_text(progress, std::chrono::duration<double>(now - start_).count());
  // A line that wraps cannot be drawn over.
  winsize terminal{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &terminal) == 0 && terminal.ws_col > 1)
    text.resize(std::min<size_t>(text.size(), terminal.ws_col - 1u));
  const size_t length = text.size();
  if (length < length_) text.append(length_ - length, ' ');
  std::fprintf(stderr, "\r%s", text.c_str());
  length_ = length;
}

void ProgressLine::end() {
  if (length_ > 0) std::fputs("\n", stderr);
  length_ = 0;
}

}  // namespace tetragauge::cli
