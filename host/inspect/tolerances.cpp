// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/tolerances.hpp"

#include <algorithm>

#include "host/inspect/applies_to.hpp"

namespace tetragauge {

FaceTolerance Tolerances::of(const Face& face) const {
  FaceTolerance out = by_default;
  const auto overlay = [&](const auto& map, const auto& id) {
    const auto at = map.find(id);
    if (at == map.end()) return;
    for (const LimitKey& key : kLimitKeys)
      if (at->second.*key.member) out.*key.member = at->second.*key.member;
    for (const DatumLimitKey& key : kDatumLimitKeys)
      if (at->second.*key.member) out.*key.member = at->second.*key.member;
  };
  overlay(by_type, face.type);
  overlay(by_surface, face.surface);
  overlay(by_face, face.id);
  if (!why_no_radius(face).empty()) out.radius_mm.reset();
  for (const DatumLimitKey& key : kDatumLimitKeys) {
    auto& limit = out.*key.member;
    const Datum* to = limit ? datum(limit->datum) : nullptr;
    if (limit && (!to || !why_not_to_datum(key.name, face, *to).empty())) limit.reset();
  }
  return out;
}

const Datum* Tolerances::datum(std::string_view name) const {
  const auto at =
      std::find_if(datums.begin(), datums.end(), [&](const Datum& datum) { return datum.name == name; });
  return at == datums.end() ? nullptr : &*at;
}

bool has_tolerance(const FaceTolerance& tolerance) {
  return std::any_of(kLimitKeys.begin(), kLimitKeys.end(),
                     [&](const LimitKey& key) { return (tolerance.*key.member).has_value(); }) ||
         std::any_of(kDatumLimitKeys.begin(), kDatumLimitKeys.end(),
                     [&](const DatumLimitKey& key) { return (tolerance.*key.member).has_value(); });
}

double offset_limit(const FaceTolerance& tolerance) {
  double limit = 1e300;
  if (tolerance.offset_mm) limit = std::min(limit, *tolerance.offset_mm);
  if (tolerance.profile_mm) limit = std::min(limit, *tolerance.profile_mm / 2);
  return limit;
}

}  // namespace tetragauge
