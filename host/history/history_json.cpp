// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/summary.hpp"
#include "host/report/json_values.hpp"

namespace tetragauge {
namespace {

using nlohmann::ordered_json;

ordered_json or_null(const std::optional<double>& value) {
  return value ? json_number(*value) : ordered_json(nullptr);
}

ordered_json or_null(const std::optional<Interval>& interval) {
  if (!interval) return nullptr;
  return {json_number(interval->low), json_number(interval->high)};
}

ordered_json or_null(const std::string& text) {
  return text.empty() ? ordered_json(nullptr) : ordered_json(text);
}

ordered_json part_json(const PartRecord& part) {
  return {{"number", part.number},
          {"part", part.part},
          {"verdict", verdict_name(part.verdict)},
          {"reason", or_null(part.reason)},
          {"machine_id", part.machine_id},
          {"calibration_id", part.calibration_id},
          {"operator", or_null(part.operator_name)},
          {"start_time", or_null(part.start_time)},
          {"seed", part.seed ? ordered_json(*part.seed) : ordered_json(nullptr)},
          {"tolerances_sha256", or_null(part.tolerances_sha256)},
          {"plan_sha256", or_null(part.plan_sha256)},
          {"software", part.software}};
}

ordered_json quantity_json(const ModelHistory& model, const QuantityHistory& quantity) {
  const Capability& c = quantity.capability;
  ordered_json json{
      {"name", quantity.name},
      {"unit", quantity.unit},
      {"n", c.n},
      {"mean", json_number(c.mean)},
      {"s", json_number(c.s)},
      {"min", json_number(c.min)},
      {"max", json_number(c.max)},
      {"lower_limit", or_null(quantity.lower)},
      {"upper_limit", or_null(quantity.upper)},
      {"limits_changed", quantity.limits_changed},
      {"left_out", quantity.unknown},
      {"n_too_small", c.n < kFewestForCapability},
      {"Cp", or_null(c.cp)},
      {"Cp_95", or_null(c.cp_interval)},
      {"Cpk", or_null(c.cpk)},
      {"Cpk_95", or_null(c.cpk_interval)},
      {"control",
       {{"centre", json_number(quantity.chart.centre)}, {"sigma", json_number(quantity.chart.sigma)}}}};
  json["out_of_control"] = ordered_json::array();
  for (const OutOfControl& signal : quantity.chart.signals) {
    const PartRecord& part = model.parts[quantity.values[signal.index].part];
    json["out_of_control"].push_back({{"part", part.number}, {"rule", signal.rule}});
  }
  json["values"] = ordered_json::array();
  for (const HistoryValue& value : quantity.values) {
    json["values"].push_back({{"part", model.parts[value.part].number},
                              {"value", json_number(value.value)},
                              {"U", json_number(value.U)}});
  }
  return json;
}

}  // namespace

ordered_json history_json(const std::vector<ModelHistory>& models, int only) {
  ordered_json json{{"schema", "tetragauge/history/1"}, {"models", ordered_json::array()}};
  for (const ModelHistory& model : models) {
    ordered_json& entry = json["models"].emplace_back();
    entry["model_sha256"] = model.model_sha256;
    entry["model_name"] = model.model_name;
    entry["held_by"] = or_null(model.held_by);
    entry["parts"] = ordered_json::array();
    for (const PartRecord& part : model.parts) entry["parts"].push_back(part_json(part));
    entry["faces"] = ordered_json::array();
    for (const FaceHistory& face : model.faces) {
      if (only != 0 && face.face != only) continue;
      ordered_json& of_face = entry["faces"].emplace_back();
      of_face["face"] = face.face;
      of_face["type"] = face.type;
      of_face["failed"] = face.failed;
      of_face["undecided"] = face.undecided;
      of_face["not_measured"] = face.not_measured;
      of_face["quantities"] = ordered_json::array();
      for (const QuantityHistory& quantity : face.quantities)
        of_face["quantities"].push_back(quantity_json(model, quantity));
    }
  }
  return json;
}

}  // namespace tetragauge
