// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "host/history/summary.hpp"

namespace tetragauge {
namespace {

bool is_measured(const PartRecord& part) {
  return !part.faces.empty();
}

// A part that could not be measured says nothing of how it was to be held: it joins its model's first group.
ModelHistory& group_of(std::vector<ModelHistory>& models, const PartRecord& part) {
  for (ModelHistory& model : models) {
    if (model.model_sha256 == part.model_sha256 && (!is_measured(part) || model.held_by == part.held_by))
      return model;
  }
  models.push_back({part.model_sha256, part.model_name, part.held_by, {}, {}});
  return models.back();
}

FaceHistory& face_of(std::vector<FaceHistory>& faces, const FaceRecord& record) {
  const auto at = std::lower_bound(faces.begin(), faces.end(), record.face,
                                   [](const FaceHistory& f, int face) { return f.face < face; });
  if (at != faces.end() && at->face == record.face) return *at;
  return *faces.insert(at, {.face = record.face, .type = record.type, .quantities = {}});
}

QuantityHistory& quantity_of(std::vector<QuantityHistory>& quantities, const Quantity& quantity) {
  for (QuantityHistory& known : quantities)
    if (known.name == quantity.name && known.unit == quantity.unit) return known;
  quantities.push_back({.name = quantity.name,
                        .unit = quantity.unit,
                        .lower = quantity.lower,
                        .upper = quantity.upper,
                        .values = {},
                        .capability = {},
                        .chart = {}});
  return quantities.back();
}

void add_part(ModelHistory& model, const PartRecord& part) {
  const size_t index = model.parts.size();
  model.parts.push_back(part);
  for (const FaceRecord& record : part.faces) {
    FaceHistory& face = face_of(model.faces, record);
    face.not_measured += !record.measured;
    face.undecided += record.verdict == Verdict::undecided;
    face.failed += record.verdict == Verdict::fail;
    for (const Quantity& quantity : record.quantities) {
      QuantityHistory& history = quantity_of(face.quantities, quantity);
      history.limits_changed |= history.lower != quantity.lower || history.upper != quantity.upper;
      history.lower = quantity.lower;
      history.upper = quantity.upper;
      if (quantity.is_known) {
        history.values.push_back({index, quantity.value, quantity.U});
      } else {
        ++history.unknown;
      }
    }
  }
}

}  // namespace

std::vector<ModelHistory> summarise(const std::vector<PartRecord>& parts) {
  std::vector<ModelHistory> models;
  // Groups are made by measured parts; then all parts go into them in their order.
  for (const PartRecord& part : parts)
    if (is_measured(part)) group_of(models, part);
  for (const PartRecord& part : parts) add_part(group_of(models, part), part);
  for (ModelHistory& model : models) {
    for (FaceHistory& face : model.faces) {
      for (QuantityHistory& quantity : face.quantities) {
        std::vector<double> values;
        for (const HistoryValue& value : quantity.values) values.push_back(value.value);
        quantity.capability = capability_of(values, quantity.lower, quantity.upper);
        quantity.chart = control_chart(values);
      }
    }
  }
  std::stable_sort(models.begin(), models.end(), [](const ModelHistory& a, const ModelHistory& b) {
    return a.parts.front().number < b.parts.front().number;
  });
  return models;
}

}  // namespace tetragauge
