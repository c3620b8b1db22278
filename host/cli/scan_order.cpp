// SPDX-License-Identifier: GPL-3.0-or-later
// What was asked of a scan, as its journal keeps it: enough that `--resume` needs nothing else. Options that
// are given again all the same must say the same.
#include "host/base/whole_file.hpp"
#include "host/cli/scan_options.hpp"

namespace tetragauge::cli {
namespace {

using nlohmann::ordered_json;

// A file by its place and content; empty: not given.
ordered_json file_entry(const std::filesystem::path& path) {
  if (path.empty()) return nullptr;
  const auto content = read_whole_file(path);
  return {{"path", std::filesystem::absolute(path).lexically_normal().string()},
          {"sha256", content ? sha256_hex(*content) : ""}};
}

}  // namespace

ordered_json ScanArguments::order() const {
  return {{"port", machine.port},
          {"baud", machine.baud},
          {"emulated", file_entry(machine.emulated.part)},
          {"board", machine.emulated.board},
          {"place", machine.emulated.place},
          {"seed", machine.emulated.seed},
          {"world", file_entry(machine.emulated.world)},
          {"plan", file_entry(plan)},
          {"pitch", default_plan.pitch_mm},
          {"keep-table", keep_table},
          {"part-serial", part_serial},
          {"operator", operator_name},
          {"start_time", start_time_}};
}

Status ScanArguments::take_order(const ordered_json& then) {
  const std::string name = journal_->path().string();
  const ordered_json now = order();
  for (const auto& [key, value] : now.items()) {
    if (!then.contains(key)) return bad_input(name + ": it does not say \"" + key + "\"; scan anew");
  }
  const auto text = [](const ordered_json& value) {
    return value.is_string()   ? value.get<std::string>()
           : value.is_object() ? value.value("path", "")
                               : value.dump();
  };
  const auto differs = [&](const std::string& key) {
    return usage_error("--" + key + " " + text(now[key]) + ": the scan in " + name + " was begun with " +
                       (then[key].empty() || then[key] == "" ? "none" : text(then[key])) +
                       "; leave the option out to go on with it, or move that file away to scan anew");
  };
  for (const char* key : {"emulated", "board", "place", "seed", "world", "plan", "pitch", "keep-table",
                          "part-serial", "operator"}) {
    if (command_->count("--" + std::string(key)) == 0 || now[key] == then[key]) continue;
    if (!now[key].is_object() ||
        now[key].value("sha256", "") != (then[key].is_object() ? then[key].value("sha256", "") : ""))
      return differs(key);
  }
  // The same machine may hang on another port today; a part on an emulated one cannot.
  if (machine.port.empty()) {
    machine.port = then["port"];
    machine.baud = then["baud"];
  }
  if (!machine.port.empty() && !then["emulated"].is_null()) return differs("port");
  for (const auto& [key, path] : std::initializer_list<std::pair<const char*, std::filesystem::path*>>{
           {"emulated", &machine.emulated.part}, {"world", &machine.emulated.world}}) {
    if (then[key].is_null()) continue;
    *path = then[key].value("path", "");
    if (file_entry(*path)["sha256"] != then[key]["sha256"]) {
      return bad_input(path->string() + ": it has changed since the scan in " + name +
                       " was begun; bring back what it was, or move that file away to scan anew");
    }
  }
  machine.emulated.board = then["board"];
  machine.emulated.place = then["place"];
  machine.emulated.seed = then["seed"];
  if (!then["plan"].is_null()) plan = then["plan"].value("path", "");
  default_plan.pitch_mm = then["pitch"];
  keep_table = then["keep-table"];
  part_serial = then["part-serial"];
  operator_name = then["operator"];
  start_time_ = then["start_time"];
  return Done{};
}

}  // namespace tetragauge::cli
