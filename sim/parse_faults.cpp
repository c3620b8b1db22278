// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "host/base/excerpt.hpp"
#include "host/base/nearest_name.hpp"
#include "host/geometry/parse_number.hpp"
#include "sim/faults.hpp"

namespace tetragauge::sim {
namespace {

using Unit = std::pair<std::string_view, double>;
constexpr Unit kTimeUnits[] = {{"ms", 1e6}, {"us", 1e3}, {"s", 1e9}};  // in ns; "s" ends the others too
constexpr Unit kCurrentUnits[] = {{"uA", 1e-6}, {"nA", 1e-9}, {"mA", 1e-3}};
constexpr double kLongest_ns = 1e15;  // eleven days

// A number not below zero with one of the units behind it.
template <size_t kCount>
std::optional<double> with_unit(std::string_view text, const Unit (&units)[kCount]) {
  for (const auto& [name, factor] : units) {
    if (!text.ends_with(name)) continue;
    const auto number = parse_number<double>(text.substr(0, text.size() - name.size()));
    if (number && *number >= 0) return *number * factor;
    return std::nullopt;
  }
  return std::nullopt;
}

std::optional<int64_t> time_ns(std::string_view text) {
  const auto ns = with_unit(text, kTimeUnits);
  if (!ns || *ns > kLongest_ns) return std::nullopt;
  return std::llround(*ns);
}

Error wrong(std::string_view word, const std::string& what) {
  return usage_error("--faults: " + excerpt(word) + ": " + what);
}

// ---- NAME@TIME[+DURATION][:VALUE]

struct TimedWord {
  // Takes what stands behind the colon (empty: nothing); false: it is not understood.
  std::function<bool(Faults&, const TimeSpan&, std::string_view value)> add;
  bool needs_duration = false;
  std::string value_help{};  // empty: takes none
};

TimedWord plain(std::vector<TimeSpan> MachineFaults::*spans) {
  return {.add = [spans](Faults& faults, const TimeSpan& when, std::string_view value) {
    (faults.machine.*spans).push_back(when);
    return value.empty();
  }};
}

bool add_flash(Faults& faults, const TimeSpan& when, std::string_view value) {
  const auto current_A = with_unit(value, kCurrentUnits);
  if (current_A) faults.machine.flashes.push_back({when, *current_A});
  return current_A.has_value();
}

bool add_stuck_mirror(Faults& faults, const TimeSpan& when, std::string_view value) {
  if (value.empty()) value = "a";
  if (value != "a" && value != "b") return false;
  faults.machine.mirror_stuck[value == "a" ? 0 : 1].push_back(when);
  return true;
}

bool add_rail(Faults& faults, const TimeSpan& when, std::string_view value) {
  if (value.empty()) value = "1x1";
  constexpr std::string_view kChannels[] = {"x1", "x2", "y1", "y2"};
  if (value.size() != 3 || (value[0] != '1' && value[0] != '2')) return false;
  for (size_t channel = 0; channel < 4; ++channel) {
    if (value.substr(1) != kChannels[channel]) continue;
    faults.machine.railed.push_back({when, value[0] == '1' ? size_t{0} : size_t{1}, channel});
    return true;
  }
  return false;
}

bool add_cut(Faults& faults, const TimeSpan& when, std::string_view value) {
  faults.line_cut.push_back(when);
  return value.empty();
}

const std::map<std::string_view, TimedWord>& timed_words() {
  static const std::map<std::string_view, TimedWord> kWords{
      {"interlock", plain(&MachineFaults::interlock_open)},
      {"limit_low", plain(&MachineFaults::limit_low)},
      {"limit_high", plain(&MachineFaults::limit_high)},
      {"laser_failing", plain(&MachineFaults::laser_failing)},
      {"laser_dark", plain(&MachineFaults::laser_dark)},
      {"mirror_stuck", {.add = add_stuck_mirror, .value_help = ":a or :b"}},
      {"adc_rail", {.add = add_rail, .value_help = ":1x1, :1x2, :1y1, :1y2, :2x1, ... (camera, electrode)"}},
      {"flash", {.add = add_flash, .needs_duration = true, .value_help = "its current, e.g. :5uA"}},
      {"link_cut", {.add = add_cut, .needs_duration = true}},
  };
  return kWords;
}

Status apply_timed(std::string_view word, const TimedWord& kind, std::string_view text, Faults& faults) {
  std::string_view value;
  const size_t colon = text.find(':');
  const bool has_value = colon != std::string_view::npos;
  if (has_value) {
    value = text.substr(colon + 1);
    text = text.substr(0, colon);
  }
  const size_t plus = text.find('+');
  const auto from = time_ns(text.substr(0, plus));
  if (!from) return wrong(word, "the time after @ is a number with its unit, e.g. @2.5s, @300ms");
  TimeSpan when{.from_ns = *from};
  if (plus != std::string_view::npos) {
    const auto duration = time_ns(text.substr(plus + 1));
    if (!duration || *duration == 0)
      return wrong(word, "the duration after + is a number above 0 with its unit, e.g. +0.2s, +300ms");
    when.until_ns = *from + *duration;
  } else if (kind.needs_duration) {
    return wrong(word, "needs a duration, e.g. @5s+2s");
  }
  if (has_value && kind.value_help.empty()) return wrong(word, "takes nothing after its time");
  if ((has_value && value.empty()) || !kind.add(faults, when, value))
    return wrong(word, "after its time stands " + kind.value_help);
  return Done{};
}

// ---- NAME[/to_host|/to_machine]=RATE[:TIME]

const std::map<std::string_view, double LineFaults::*>& rate_words() {
  static const std::map<std::string_view, double LineFaults::*> kWords{
      {"link_flip", &LineFaults::flip},
      {"link_drop", &LineFaults::drop},
      {"link_duplicate", &LineFaults::duplicate},
      {"link_delay", &LineFaults::delay},
  };
  return kWords;
}

Status apply_rate(std::string_view word, std::string_view name, std::string_view direction,
                  std::string_view text, Faults& faults) {
  const auto rate_of = rate_words().at(name);
  std::optional<int64_t> delay_ns;
  if (const size_t colon = text.find(':'); colon != std::string_view::npos) {
    if (name != "link_delay") return wrong(word, "takes a share of the bytes alone, e.g. =1e-4");
    delay_ns = time_ns(text.substr(colon + 1));
    if (!delay_ns) return wrong(word, "the delay is a number with its unit, e.g. :50ms");
    text = text.substr(0, colon);
  }
  const auto rate = parse_number<double>(text);
  if (!rate || *rate < 0 || *rate > 1)
    return wrong(word, "the share of the bytes is from 0 to 1, e.g. =1e-4");
  if (!direction.empty() && direction != "to_host" && direction != "to_machine")
    return wrong(word, "a direction is /to_host or /to_machine; without one, both");
  for (LineFaults* line : {&faults.to_host, &faults.to_machine}) {
    if (direction == "to_host" && line != &faults.to_host) continue;
    if (direction == "to_machine" && line != &faults.to_machine) continue;
    line->*rate_of = *rate;
    if (delay_ns) line->delay_ns = *delay_ns;
  }
  return Done{};
}

Error unknown_word(std::string_view word, std::string_view name) {
  std::vector<std::string_view> known{"seed"};
  for (const auto& entry : timed_words()) known.push_back(entry.first);
  for (const auto& entry : rate_words()) known.push_back(entry.first);
  return wrong(
      word, "unknown fault \"" + excerpt(name) + "\"; did you mean \"" + nearest_name(name, known) + "\"?");
}

Status apply_word(std::string_view word, Faults& faults) {
  const size_t name_end = word.find_first_of("@=/");
  const std::string_view name = word.substr(0, name_end);
  const size_t at = word.find('@'), equals = word.find('=');
  if (const auto timed = timed_words().find(name); timed != timed_words().end()) {
    if (at == std::string_view::npos || name_end != at)
      return wrong(word, "needs the time at which it happens, e.g. " + std::string(name) + "@2.5s");
    return apply_timed(word, timed->second, word.substr(at + 1), faults);
  }
  if (rate_words().contains(name)) {
    if (equals == std::string_view::npos)
      return wrong(word, "needs a share of the bytes, e.g. " + std::string(name) + "=1e-4");
    const std::string_view direction =
        name_end == equals ? std::string_view() : word.substr(name_end + 1, equals - name_end - 1);
    if (name_end != equals && (word[name_end] != '/' || direction.empty()))
      return wrong(word, "a direction is /to_host or /to_machine; without one, both");
    return apply_rate(word, name, direction, word.substr(equals + 1), faults);
  }
  if (name == "seed") {
    const auto seed = equals == name_end && equals != std::string_view::npos
                          ? parse_number<uint64_t>(word.substr(equals + 1))
                          : std::nullopt;
    if (!seed) return wrong(word, "a seed is a whole number, e.g. seed=7");
    faults.seed = *seed;
    return Done{};
  }
  return unknown_word(word, name);
}

}  // namespace

Result<Faults> parse_faults(const std::string& spec) {
  Faults faults;
  std::string_view rest = spec;
  if (rest.empty()) return usage_error("--faults: empty; e.g. interlock@2.5s or link_flip=1e-4,seed=2");
  for (bool more = true; more;) {
    const size_t comma = rest.find(',');
    more = comma != std::string_view::npos;
    const std::string_view word = rest.substr(0, comma);
    if (word.empty())
      return usage_error("--faults " + excerpt(spec) +
                         ": an empty word between commas; words are joined by one comma");
    if (const Status done = apply_word(word, faults); !done) return done.error();
    if (more) rest.remove_prefix(comma + 1);
  }
  return faults;
}

}  // namespace tetragauge::sim
