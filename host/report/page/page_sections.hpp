// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the page that need no script, written from the keys of report.json.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tetragauge {

// `json`: as report_json() gives it. Each is a whole <section>, or empty when there is nothing to say.
std::string faces_section(const nlohmann::ordered_json& json);  // the table, worst first
std::string findings_section(
    const nlohmann::ordered_json& json);                       // missing, extra, misplaced, material; remarks
std::string pose_section(const nlohmann::ordered_json& json);  // what holds the part, equivalents
std::string measuring_section(
    const nlohmann::ordered_json& json);  // plan and rounds, where `measure` told them
std::string relations_section(const nlohmann::ordered_json& json);
std::string facts_section(const nlohmann::ordered_json& json);  // files, machine, counts, versions

// "3 fail, 1 undecided, 11 pass" as list items.
std::string verdict_counts(const nlohmann::ordered_json& json);

struct VerdictSign {
  const char *symbol, *word;  // UTF-8; told apart without colour
};
VerdictSign verdict_sign(const std::string& verdict);

}  // namespace tetragauge
