// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/geometry/face.hpp"

namespace tetragauge {

std::string_view surface_type_name(SurfaceType type) {
  switch (type) {
    case SurfaceType::plane:
      return "plane";
    case SurfaceType::cylinder:
      return "cylinder";
    case SurfaceType::cone:
      return "cone";
    case SurfaceType::sphere:
      return "sphere";
    case SurfaceType::torus:
      return "torus";
    case SurfaceType::other:
      return "other";
  }
  return "other";
}

std::optional<SurfaceType> surface_type_from_name(std::string_view name) {
  for (const SurfaceType type : {SurfaceType::plane, SurfaceType::cylinder, SurfaceType::cone,
                                 SurfaceType::sphere, SurfaceType::torus, SurfaceType::other}) {
    if (surface_type_name(type) == name) return type;
  }
  return std::nullopt;
}

}  // namespace tetragauge
