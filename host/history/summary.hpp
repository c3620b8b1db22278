// SPDX-License-Identifier: GPL-3.0-or-later
// What many parts say about each face: statistics, capability, what is out of control.
//
//   for (const ModelHistory& model : summarise(parts)) text += history_text(model, {});
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/history/capability.hpp"
#include "host/history/control_chart.hpp"
#include "host/history/part_record.hpp"

namespace tetragauge {

struct HistoryValue {
  size_t part = 0;  // index into ModelHistory::parts
  double value = 0, U = 0;
};

// One quantity of one face over all parts, in their order.
struct QuantityHistory {
  std::string name, unit;
  std::optional<double> lower{}, upper{};  // of the last part that has the quantity
  bool limits_changed = false;             // earlier parts had others
  size_t unknown = 0;                      // parts in which it rests on a datum that was not measured
  std::vector<HistoryValue> values;
  Capability capability;
  ControlChart chart;
};

struct FaceHistory {
  int face = 0;
  std::string type;
  size_t not_measured = 0, undecided = 0, failed = 0;  // parts
  std::vector<QuantityHistory> quantities;             // in the order in which they first came
};

// Parts of one model, held alike.
struct ModelHistory {
  std::string model_sha256, model_name, held_by;
  std::vector<PartRecord> parts;   // those without a measurement too
  std::vector<FaceHistory> faces;  // by model id
};

// Models in the order of their first parts.
std::vector<ModelHistory> summarise(const std::vector<PartRecord>& parts);

struct HistoryTextOptions {
  bool unicode = false;  // block characters in the charts
  bool colour = false;   // ANSI: what is out of control or beyond its limits in red
  int face = 0;          // only this face, with its values part by part; 0: all, in short
};

// Fits 100 columns.
std::string history_text(const ModelHistory& model, const HistoryTextOptions& options);
// A line a part: what the end of a batch shows.
std::string parts_table(const std::vector<PartRecord>& parts);
// Schema tetragauge/history/1; face 0: all.
nlohmann::ordered_json history_json(const std::vector<ModelHistory>& models, int face);

}  // namespace tetragauge
