// SPDX-License-Identifier: GPL-3.0-or-later
// The text or bytes of mesh files as triangles. Polygons are cut into triangles; colours, normals and texture
// are passed over. Errors name the file and the line (or the element), what is wrong and what to do.
#pragma once

#include <string>
#include <string_view>

#include "host/base/result.hpp"
#include "host/solid/triangle_mesh.hpp"

namespace tetragauge {

// Binary or ASCII, told apart by the size that the binary header promises. Every triangle has corners of its
// own.
Result<TriangleMesh> parse_stl(std::string_view content, const std::string& file);
Result<TriangleMesh> parse_obj(std::string_view content, const std::string& file);
Result<TriangleMesh> parse_off(std::string_view content, const std::string& file);
// Elements `vertex` and `face`, ASCII or binary of either byte order; `comment unit mm` is the declared unit.
Result<TriangleMesh> parse_ply_mesh(std::string_view content, const std::string& file);

}  // namespace tetragauge
