// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "host/base/excerpt.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/solid/cut_polygon.hpp"
#include "host/solid/parse_mesh.hpp"

namespace tetragauge {
namespace {

// Statements without an effect on the surface.
constexpr std::array<std::string_view, 20> kPassedOver{
    "vt", "vn",     "vp",     "g",     "o",   "s",        "mg",       "usemtl",     "mtllib",    "l",
    "p",  "usemap", "maplib", "bevel", "lod", "c_interp", "d_interp", "shadow_obj", "trace_obj", "call"};

// The corner's vertex, counted from 0: "7", "7/1", "7//3", "7/1/3", or counted back from the last: "-1".
std::optional<int64_t> corner_of(std::string_view word, size_t vertices) {
  const auto index = parse_number<int64_t>(word.substr(0, word.find('/')));
  if (!index || *index == 0) return std::nullopt;
  return *index > 0 ? *index - 1 : *index + static_cast<int64_t>(vertices);
}

// Like next_line, with lines continued by a backslash put together.
std::string whole_line(std::string_view& text, int& number) {
  std::string whole;
  for (;;) {
    std::string_view line = next_line(text);
    ++number;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    const bool goes_on = !line.empty() && line.back() == '\\' && !text.empty();
    if (goes_on) line.remove_suffix(1);
    whole += line;
    if (!goes_on) return whole;
    whole += ' ';
  }
}

}  // namespace

Result<TriangleMesh> parse_obj(std::string_view content, const std::string& file) {
  TriangleMesh mesh;
  std::vector<int64_t> corners;
  int number = 0;
  while (!content.empty()) {
    const std::string text = whole_line(content, number);
    std::string_view line = text;
    line = line.substr(0, line.find('#'));
    const std::string_view key = next_word(line);
    if (key.empty()) continue;
    const std::string place = file + ":" + std::to_string(number) + ": ";
    if (key == "v") {
      Vec3 p;
      for (int k = 0; k < 3; ++k) {
        const auto value = parse_number<double>(next_word(line));
        if (!value) return bad_input(place + "a vertex needs three numbers; export it again");
        p[k] = *value;
      }
      mesh.vertices.push_back(p);
    } else if (key == "f" || key == "fo") {
      corners.clear();
      for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
        const auto corner = corner_of(word, mesh.vertices.size());
        if (!corner) {
          return bad_input(place + "'" + excerpt(word) + "' is no corner of a face; export it again");
        }
        corners.push_back(*corner);
      }
      if (Status status = add_polygon(corners, place, mesh); !status) return status.error();
    } else if (std::find(kPassedOver.begin(), kPassedOver.end(), key) == kPassedOver.end()) {
      return bad_input(place + "'" + excerpt(key) +
                       "' is not supported; export the part as OBJ with vertices (v) and faces (f)");
    }
  }
  return mesh;
}

}  // namespace tetragauge
