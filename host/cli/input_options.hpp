// SPDX-License-Identifier: GPL-3.0-or-later
// The options by which scans and models are named and completed, alike in every command.
#pragma once

#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/scan/scan_file.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge::cli {

// The endings of solid models, for help texts.
extern const char* const kModelFiles;

struct InputOptions {
  std::string scan, model;
  std::string unit, scan_unit, model_unit;
  std::string ray_origin, ray_direction;
  double sigma_mm = 0;
  bool keep_facets = false;

  void add_scan(CLI::App& command);
  // Several of one part, each in a set-up of its own.
  void add_scans(CLI::App& command, std::vector<std::string>& scans);
  void add_model(CLI::App& command);
  void add_facets(CLI::App& command);
  // --unit, and what of --scan-unit, --model-unit goes with the inputs added before
  void add_unit(CLI::App& command);

  Result<Scan> read_scan(const Console& console) const { return read_scan(console, scan); }
  Result<Scan> read_scan(const Console& console, const std::string& path) const;
  Result<Solid> read_model(const Console& console) const;
  // mm per unit said for the model, if any.
  Result<double> model_unit_mm() const;

 private:
  void complete_scan(CLI::App& command);
};

// "X,Y,Z"; a usage error names `option`.
Result<Vec3> parse_vec3(const std::string& text, const std::string& option);

}  // namespace tetragauge::cli
