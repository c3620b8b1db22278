// SPDX-License-Identifier: GPL-3.0-or-later
// The tolerance file (DESIGN section 4): face over surface over type over default. Unknown keys are errors
// that name the nearest known one.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/result.hpp"
#include "host/geometry/face.hpp"

namespace tetragauge {

// To a datum, in the unit of its key.
struct DatumTolerance {
  double value = 0;
  std::string datum;  // a key of `datums`
};

struct FaceTolerance {
  std::optional<double> profile_mm;   // full width of the zone (ISO 1101): limits are +- half of it
  std::optional<double> offset_mm;    // +- limit
  std::optional<double> radius_mm;    // +- limit; cylinder, sphere
  std::optional<double> flatness_mm;  // full zone
  std::optional<DatumTolerance> position_mm, parallelism_mm, perpendicularity_mm;  // full zones
  std::optional<DatumTolerance> angularity_mrad;                                   // +- limit
};

// What a tolerance may say, in the order of the report.
struct LimitKey {
  std::string_view name;
  std::optional<double> FaceTolerance::*member;
};
inline constexpr std::array kLimitKeys{
    LimitKey{"profile_mm", &FaceTolerance::profile_mm}, LimitKey{"offset_mm", &FaceTolerance::offset_mm},
    LimitKey{"radius_mm", &FaceTolerance::radius_mm}, LimitKey{"flatness_mm", &FaceTolerance::flatness_mm}};
struct DatumLimitKey {
  std::string_view name;
  std::optional<DatumTolerance> FaceTolerance::*member;
};
inline constexpr std::array kDatumLimitKeys{
    DatumLimitKey{"position_mm", &FaceTolerance::position_mm},
    DatumLimitKey{"parallelism_mm", &FaceTolerance::parallelism_mm},
    DatumLimitKey{"perpendicularity_mm", &FaceTolerance::perpendicularity_mm},
    DatumLimitKey{"angularity_mrad", &FaceTolerance::angularity_mrad}};

// A plane face of the model by which the part is held, or that others are measured against.
struct Datum {
  std::string name;  // a capital letter; the first three hold the part: A before B before C
  int face = 0;
  Vec3 normal = Vec3::Zero();  // of that face, model frame
};

struct Tolerances {
  bool given = false;  // a file was read
  FaceTolerance by_default;
  std::map<SurfaceType, FaceTolerance> by_type;
  std::map<int, FaceTolerance> by_surface, by_face;
  std::vector<Datum> datums;  // by name
  std::set<int> skip;         // face ids
  double min_coverage = 0.5;

  // What holds for one face, key by key; keys that mean nothing on it (the radius of a plane) are left out.
  FaceTolerance of(const Face& face) const;
  const Datum* datum(std::string_view name) const;  // nullptr: no such datum
};

// Checked against the model: ids that it does not have, datums that are no planes or do not hold the part,
// and keys that mean nothing on the face they are given for are errors.
Result<Tolerances> read_tolerances(const std::filesystem::path& path, const FaceList& model);

bool has_tolerance(const FaceTolerance& tolerance);

// The limit that a face's offset must keep to, mm: the tighter of profile and offset; 1e300 without either.
double offset_limit(const FaceTolerance& tolerance);

}  // namespace tetragauge
