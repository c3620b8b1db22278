// SPDX-License-Identifier: GPL-3.0-or-later
// tetragauge-hello: says Hello to a machine and prints version, status, log lines and self-test.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/hello/bench_actions.hpp"
#include "host/link/link.hpp"
#include "protocol/state_name.hpp"

namespace tetragauge {
namespace {

using Json = nlohmann::ordered_json;

std::atomic<bool> stop_asked{false};

void ask_to_stop(int) {
  stop_asked = true;
}

struct Options {
  std::string port;
  int baud = TransportOptions{}.baud;
  int rounds = 0, patience_s = static_cast<int>(LinkOptions{}.silence.count() / 1000);
  bool json = false, bootloader = false;
  BenchActions actions;
};

const char* name_of(tg_SelfTestCheck check) {
  static const char* const kNames[] = {"none",           "interlock",     "mirrors",       "laser driver",
                                       "converter",      "dark camera 1", "dark camera 2", "noise camera 1",
                                       "noise camera 2", "store",         "step timers",   "clock",
                                       "transport"};
  static_assert(sizeof kNames / sizeof kNames[0] == _tg_SelfTestCheck_MAX + 1);
  return check <= _tg_SelfTestCheck_MAX ? kNames[check] : "a check of a newer machine";
}

const char* name_of(tg_SelfTestResult result) {
  static const char* const kNames[] = {"none", "passed", "FAILED", "absent"};
  static_assert(sizeof kNames / sizeof kNames[0] == _tg_SelfTestResult_MAX + 1);
  return result <= _tg_SelfTestResult_MAX ? kNames[result] : "unknown";
}

const char* name_of(tg_ResetCause cause) {
  static const char* const kNames[] = {"an unknown cause", "power", "the reset pin", "software",
                                       "the watchdog"};
  static_assert(sizeof kNames / sizeof kNames[0] == _tg_ResetCause_MAX + 1);
  return cause <= _tg_ResetCause_MAX ? kNames[cause] : kNames[0];
}

// `test`: nothing in it where the machine did not run it.
Json describe(const tg_HelloReply& hello, const tg_Status& status, const std::vector<std::string>& logs,
              const tg_SelfTestReply& test) {
  Json out;
  out["board"] = hello.board;
  out["firmware_version"] = hello.firmware_version;
  out["protocol_version"] = hello.protocol_version;
  out["boot_id"] = hello.boot_id;
  out["started_by"] = name_of(hello.reset_cause);
  out["calibration"] = hello.calibration_id;
  out["state"] = state_name(status.state);
  out["clock_us"] = status.clock_us;
  out["inputs"] = status.inputs;
  out["log"] = logs;
  out["self_test"] = Json::array();
  for (pb_size_t i = 0; i < test.items_count; ++i) {
    const tg_SelfTestItem& item = test.items[i];
    out["self_test"].push_back({{"check", name_of(item.check)},
                                {"result", name_of(item.result)},
                                {"value", item.value},
                                {"limit", item.limit}});
  }
  out["dark_codes"] = std::vector<int32_t>(test.dark_codes, test.dark_codes + test.dark_codes_count);
  return out;
}

void print(const Json& out) {
  const auto text = [&](const char* key) { return out[key].get<std::string>(); };
  std::printf("%s, firmware %s, protocol %u\n", text("board").c_str(), text("firmware_version").c_str(),
              out["protocol_version"].get<unsigned>());
  std::printf("started by %s (boot id %08x), state %s, inputs %u, calibration: %s\n",
              text("started_by").c_str(), out["boot_id"].get<unsigned>(), text("state").c_str(),
              out["inputs"].get<unsigned>(),
              text("calibration").empty() ? "none, nominal numbers" : text("calibration").c_str());
  for (const Json& line : out["log"]) std::printf("log: %s\n", line.get<std::string>().c_str());
  if (!out["self_test"].empty()) std::printf("self-test:\n");
  for (const Json& item : out["self_test"]) {
    std::printf("  %-15s %-7s value %d, limit %d\n", item["check"].get<std::string>().c_str(),
                item["result"].get<std::string>().c_str(), item["value"].get<int>(),
                item["limit"].get<int>());
  }
  if (const std::vector<int> codes = out["dark_codes"]; codes.size() == 8) {
    for (size_t c = 0; c < 2; ++c) {
      std::printf("  camera %zu, mean codes: x1 %d, x2 %d, y1 %d, y2 %d\n", c + 1, codes[4 * c],
                  codes[4 * c + 1], codes[4 * c + 2], codes[4 * c + 3]);
    }
  }
  if (out.contains("round_trip")) {
    const auto& trip = out["round_trip"];
    std::printf("%d round trips: median %d us, 99 %% within %d us, worst %d us\n", trip["rounds"].get<int>(),
                trip["median_us"].get<int>(), trip["p99_us"].get<int>(), trip["worst_us"].get<int>());
  }
}

int fail(const Error& error) {
  std::fprintf(stderr, "tetragauge-hello: %s\n", error.message.c_str());
  return static_cast<int>(error.kind);
}

// Asks for the status again and again: how long host, line and machine take to answer.
Result<Json> time_rounds(Link& link, int rounds) {
  std::vector<int64_t> took_us;
  for (int round = 0; round < rounds; ++round) {
    const auto asked = std::chrono::steady_clock::now();
    auto status = link.status();
    if (!status) return status.error();
    const auto took = std::chrono::steady_clock::now() - asked;
    took_us.push_back(std::chrono::duration_cast<std::chrono::microseconds>(took).count());
  }
  std::sort(took_us.begin(), took_us.end());
  return Json{{"rounds", rounds},
              {"median_us", took_us[took_us.size() / 2]},
              {"p99_us", took_us[took_us.size() * 99 / 100]},
              {"worst_us", took_us.back()}};
}

int run(const Options& options) {
  TransportOptions line;
  line.baud = options.baud;
  auto transport = open_transport(options.port, line);
  if (!transport) return fail(transport.error());
  LinkOptions how;
  how.silence = std::chrono::seconds(options.patience_s);
  auto link = Link::connect(std::move(*transport), how);
  if (!link) return fail(link.error());
  tg_HostMessage message = tg_HostMessage_init_zero;
  if (options.bootloader) {
    if (Status ended = end_what_runs(**link); !ended) return fail(ended.error());
    message.which_body = tg_HostMessage_enter_bootloader_tag;
    auto done = (*link)->request(message);
    return done ? 0 : fail(done.error());
  }
  if (options.actions.any()) {
    if (Status done = run_actions(**link, options.actions, stop_asked); !done) return fail(done.error());
  }
  auto status = (*link)->status();
  if (!status) return fail(status.error());
  if (options.actions.any()) {
    std::printf("state %s, inputs %u\n", state_name(status->state), status->inputs);
    return status->fault == tg_FaultCode_FAULT_NONE ? 0 : 1;
  }
  message.which_body = tg_HostMessage_self_test_tag;
  tg_SelfTestReply test = tg_SelfTestReply_init_zero;
  const auto tested = (*link)->request(message);
  if (tested) {
    test = tested->body.self_test;
  } else if (auto lives = (*link)->status(); !lives) {
    return fail(tested.error());
  }
  std::vector<std::string> logs;
  while (const auto log = (*link)->next_log()) logs.emplace_back(log->text);

  Json out = describe((*link)->machine(), *status, logs, test);
  if (options.rounds > 0) {
    auto times = time_rounds(**link, options.rounds);
    if (!times) return fail(times.error());
    out["round_trip"] = *times;
  }
  if (options.json) {
    std::printf("%s\n", out.dump(1).c_str());
  } else {
    print(out);
  }
  // A machine at work, or PAUSED: what it is in is shown all the same.
  if (!tested) return fail(tested.error());
  for (const Json& item : out["self_test"]) {
    if (item["result"] == name_of(tg_SelfTestResult_SELF_TEST_FAILED)) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace tetragauge

int main(int argc, char** argv) {
  CLI::App app("Says Hello to a machine; prints its version, state, log and self-test.", "tetragauge-hello");
  tetragauge::Options options;
  app.add_option("--port", options.port, "/dev/ttyUSB0, unix:PATH or tcp:HOST:PORT")->required();
  app.add_option("--baud", options.baud, "of a serial port")->capture_default_str();
  app.add_option("--rounds", options.rounds,
                 "ask for the status so often, and print how long the answers took")
      ->check(CLI::Range(1, 1'000'000));
  app.add_option("--patience", options.patience_s,
                 "seconds without a sign of life until a machine is given up")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  app.add_flag("--json", options.json, "as JSON");
  tetragauge::BenchActions& act = options.actions;
  app.add_flag("--home", act.home, "finds the zero of both axes");
  app.add_option("--table", act.table_deg, "turns the table by so many degrees");
  app.add_option("--slide", act.slide_mm, "drives the slide up by so many mm");
  app.add_option("--mirrors", act.mirrors_urad,
                 "swings both mirrors to these angles, urad, and leaves them there")
      ->delimiter(',')
      ->type_name("A,B");
  app.add_option("--laser", act.laser_s, "after --home: the laser on for so many seconds, or until Ctrl-C")
      ->check(CLI::Range(0.1, 600.0));
  app.add_flag("--bootloader", options.bootloader, "into the chip's bootloader, for flashing");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(tetragauge::ErrorKind::usage);
  }
  if (options.actions.any()) {
    struct sigaction action {};
    action.sa_handler = tetragauge::ask_to_stop;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
    ::sigaction(SIGHUP, &action, nullptr);
  }
  return tetragauge::run(options);
}
