// SPDX-License-Identifier: GPL-3.0-or-later
// The tolerance file (DESIGN section 4): face over surface over type over default. Unknown keys are errors
// that name the nearest known one.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "host/base/result.hpp"
#include "host/geometry/face.hpp"

namespace tetragauge {

struct FaceTolerance {
  std::optional<double> profile_mm;   // full width of the zone (ISO 1101): limits are +- half of it
  std::optional<double> offset_mm;    // +- limit
  std::optional<double> flatness_mm;  // full zone
};

struct Tolerances {
  bool given = false;  // a file was read
  FaceTolerance by_default;
  std::map<SurfaceType, FaceTolerance> by_type;
  std::map<int, FaceTolerance> by_surface, by_face;
  std::set<int> skip;  // face ids
  double min_coverage = 0.5;

  // What holds for one face, key by key.
  FaceTolerance of(const Face& face) const;
};

// Checked against the model: ids that it does not have are errors.
Result<Tolerances> read_tolerances(const std::filesystem::path& path, const FaceList& model);

}  // namespace tetragauge
