// SPDX-License-Identifier: GPL-3.0-or-later
// Face lists on disk: JSON ({schema, unit, faces: [...]}, written by `faces --json` and `model --json`) and
// .hsp (a face a line: id a b c d area, with a x + b y + c z + d = 0; # comments).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "host/base/result.hpp"
#include "host/geometry/face.hpp"

namespace tetragauge {

// mm per unit for "mm", "cm", "m", "inch" ("in"), "um"; usage error otherwise.
Result<double> unit_mm(std::string_view unit);

// By its ending: .hsp, otherwise JSON. `unit_scale_mm` scales .hsp lists, which carry no unit (JSON is in
// mm).
Result<FaceList> read_face_list(const std::filesystem::path& path, double unit_scale_mm = 1.0);

nlohmann::ordered_json face_to_json(const Face& face);
nlohmann::ordered_json face_list_to_json(const FaceList& list, std::string_view schema);

}  // namespace tetragauge
