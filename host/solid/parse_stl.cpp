// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>

#include "host/base/excerpt.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/solid/parse_mesh.hpp"

namespace tetragauge {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies in memory");

constexpr size_t kHeaderBytes = 80, kCountBytes = 4, kFacetBytes = 50, kNormalBytes = 12;

uint32_t facet_count(std::string_view content) {
  uint32_t count = 0;
  std::memcpy(&count, content.data() + kHeaderBytes, sizeof count);
  return count;
}

bool has_binary_size(std::string_view content) {
  return content.size() >= kHeaderBytes + kCountBytes &&
         content.size() == kHeaderBytes + kCountBytes + kFacetBytes * facet_count(content);
}

void add_triangle(const std::array<Vec3, 3>& corners, TriangleMesh& mesh) {
  const uint32_t first = static_cast<uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
  mesh.triangles.push_back({first, first + 1, first + 2});
}

Result<TriangleMesh> parse_binary(std::string_view content, const std::string& file) {
  const size_t count = facet_count(content);
  TriangleMesh mesh;
  mesh.vertices.reserve(3 * count);
  mesh.triangles.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const char* bytes = content.data() + kHeaderBytes + kCountBytes + kFacetBytes * i + kNormalBytes;
    std::array<float, 9> values;
    std::memcpy(values.data(), bytes, sizeof values);
    if (!std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); })) {
      return bad_input(file + ": triangle " + std::to_string(i + 1) +
                       " has a corner that is no number; export it again");
    }
    std::array<Vec3, 3> corners;
    for (size_t k = 0; k < 3; ++k) {
      corners[k] = Vec3(static_cast<double>(values[3 * k]), static_cast<double>(values[3 * k + 1]),
                        static_cast<double>(values[3 * k + 2]));
    }
    add_triangle(corners, mesh);
  }
  return mesh;
}

// ASCII STL, word by word: solid NAME (facet normal x y z outer loop (vertex x y z) x 3 endloop endfacet)...
// endsolid
class AsciiParser {
 public:
  AsciiParser(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  Result<TriangleMesh> parse() {
    TriangleMesh mesh;
    bool is_in_solid = false;
    while (next()) {
      if (!is_in_solid) {
        if (!is("solid")) return fail("'solid'");
        skip_line();
        is_in_solid = true;
      } else if (is("endsolid")) {
        skip_line();
        is_in_solid = false;
      } else if (is("facet")) {
        std::array<Vec3, 3> corners;
        if (Status status = parse_facet(corners); !status) return status.error();
        add_triangle(corners, mesh);
      } else {
        return fail("'facet' or 'endsolid'");
      }
    }
    if (is_in_solid) return fail("'endsolid'");
    return mesh;
  }

 private:
  // Takes the next word; false at the end of the text.
  bool next() {
    word_ = next_word(line_);
    while (word_.empty() && !rest_.empty()) {
      line_ = next_line(rest_);
      ++number_;
      word_ = next_word(line_);
    }
    return !word_.empty();
  }

  bool is(std::string_view expected) const {
    return std::equal(word_.begin(), word_.end(), expected.begin(), expected.end(),
                      [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
  }

  void skip_line() { line_ = {}; }

  Error fail(const std::string& expected) const {
    const std::string found = word_.empty() ? "the file ends" : "'" + excerpt(word_) + "' stands";
    return bad_input(
        file_ + ":" + std::to_string(number_) + ": " + found + " where " + expected +
        " should; export the STL file again (a binary one has 84 bytes and 50 for each triangle)");
  }

  Status expect(std::string_view word) {
    next();
    if (is(word)) return Done{};
    return fail("'" + std::string(word) + "'");
  }

  Status parse_vector(Vec3& v) {
    for (int k = 0; k < 3; ++k) {
      next();
      const auto number = parse_number<double>(word_);
      if (!number) return fail("a number");
      v[k] = *number;
    }
    return Done{};
  }

  // After `facet`.
  Status parse_facet(std::array<Vec3, 3>& corners) {
    if (Status status = expect("normal"); !status) return status;
    // The corners say the normal; some exporters write "nan" for that of a sliver.
    for (int k = 0; k < 3; ++k) {
      if (!next()) return fail("a number");
    }
    for (const char* word : {"outer", "loop"}) {
      if (Status status = expect(word); !status) return status;
    }
    for (Vec3& corner : corners) {
      if (Status status = expect("vertex"); !status) return status;
      if (Status status = parse_vector(corner); !status) return status;
    }
    for (const char* word : {"endloop", "endfacet"}) {
      if (Status status = expect(word); !status) return status;
    }
    return Done{};
  }

  std::string_view rest_, line_, word_;
  int number_ = 0;
  const std::string& file_;
};

bool begins_with_solid(std::string_view content) {
  const size_t start = content.find_first_not_of(" \t\r\n");
  return start != std::string_view::npos && content.substr(start, 5) == "solid";
}

}  // namespace

Result<TriangleMesh> parse_stl(std::string_view content, const std::string& file) {
  // Binary files may begin with "solid" too: the size decides.
  if (has_binary_size(content)) return parse_binary(content, file);
  if (begins_with_solid(content)) return AsciiParser(content, file).parse();
  if (content.size() < kHeaderBytes + kCountBytes) {
    return bad_input(file + ": " + std::to_string(content.size()) +
                     " bytes are no STL file; export it again");
  }
  return bad_input(file + ": not an STL file, or one cut short: its header promises " +
                   std::to_string(facet_count(content)) + " triangles, which need " +
                   std::to_string(kHeaderBytes + kCountBytes + kFacetBytes * facet_count(content)) +
                   " bytes, and it has " + std::to_string(content.size()) + "; export it again");
}

}  // namespace tetragauge
