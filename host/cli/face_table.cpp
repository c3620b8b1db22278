// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/face_table.hpp"

#include <cstdio>
#include <numbers>

namespace tetragauge::cli {

std::string face_table(const FaceList& list) {
  std::string table =
      " id surf type        normal or axis                  d or radius mm     area mm2  points  "
      "neighbours\n";
  for (const Face& face : list.faces) {
    const bool is_plane = face.type == SurfaceType::plane;
    const Vec3 direction = (is_plane ? face.normal : face.axis) + Vec3::Zero();  // no minus zero
    char line[200];
    std::snprintf(line, sizeof line, "%3d %4d %-9s %9.5f %9.5f %9.5f %15.4f %12.3f %7zu ", face.id,
                  face.surface, std::string(surface_type_name(face.type)).c_str(), direction.x(),
                  direction.y(), direction.z(), is_plane ? face.d_mm : face.radius_mm, face.area_mm2,
                  face.points);
    table += line;
    for (const int id : face.neighbours) table += " " + std::to_string(id);
    table += "\n";
  }
  return table;
}

}  // namespace tetragauge::cli
