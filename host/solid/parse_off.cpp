// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>

#include "host/base/excerpt.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/solid/cut_polygon.hpp"
#include "host/solid/parse_mesh.hpp"

namespace tetragauge {
namespace {

// Lines with something on them, without comments.
class Lines {
 public:
  Lines(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  // The next word, from further lines if need be; empty at the end.
  std::string_view next() {
    std::string_view word = next_word(line_);
    while (word.empty() && next_data_line()) word = next_word(line_);
    return word;
  }
  // The next word of the current line alone.
  std::string_view next_on_line() { return next_word(line_); }
  void skip_line() { line_ = {}; }
  std::string place() const { return file_ + ":" + std::to_string(number_) + ": "; }

 private:
  bool next_data_line() {
    if (rest_.empty()) return false;
    line_ = next_line(rest_);
    line_ = line_.substr(0, line_.find('#'));
    ++number_;
    return true;
  }

  std::string_view rest_, line_;
  int number_ = 0;
  const std::string& file_;
};

}  // namespace

Result<TriangleMesh> parse_off(std::string_view content, const std::string& file) {
  Lines lines(content, file);
  const std::string_view key = lines.next();
  // With colours (C) or normals (N) the first three numbers of a vertex are still its place.
  if (key != "OFF" && key != "COFF" && key != "NOFF" && key != "CNOFF") {
    return bad_input(file + ": not an OFF file, it does not begin with 'OFF'; export it again");
  }
  std::array<uint64_t, 3> counts{};  // vertices, faces, edges
  for (uint64_t& count : counts) {
    const auto number = parse_number<uint64_t>(lines.next());
    if (!number)
      return bad_input(lines.place() + "expected the numbers of vertices, faces and edges; export it again");
    count = *number;
  }
  lines.skip_line();
  // Each vertex takes 6 bytes at least, each face 8: a count beyond that is damaged, and no memory is asked
  // for it.
  if (counts[0] > content.size() / 6 + 1 || counts[1] > content.size() / 8 + 1) {
    return bad_input(lines.place() +
                     "more vertices or faces than the file can hold; it is cut short or damaged");
  }
  TriangleMesh mesh;
  mesh.vertices.reserve(counts[0]);
  for (uint64_t i = 0; i < counts[0]; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      const auto number = parse_number<double>(k == 0 ? lines.next() : lines.next_on_line());
      if (!number) {
        return bad_input(lines.place() + "vertex " + std::to_string(i) +
                         " needs three numbers; export it again");
      }
      p[k] = *number;
    }
    lines.skip_line();
    mesh.vertices.push_back(p);
  }
  std::vector<int64_t> corners;
  for (uint64_t i = 0; i < counts[1]; ++i) {
    const auto size = parse_number<uint32_t>(lines.next());
    corners.clear();
    for (uint32_t k = 0; size && k < *size; ++k) {
      const auto corner = parse_number<int64_t>(lines.next_on_line());
      if (!corner) break;
      corners.push_back(*corner);
    }
    if (!size || corners.size() != *size) {
      return bad_input(lines.place() + "face " + std::to_string(i) +
                       " needs its number of corners and as many indices; export it again");
    }
    lines.skip_line();
    if (Status status = add_polygon(corners, lines.place(), mesh); !status) return status.error();
  }
  if (const std::string_view word = lines.next(); !word.empty()) {
    return bad_input(lines.place() + "'" + excerpt(word) +
                     "' follows after all vertices and faces announced; export it again");
  }
  return mesh;
}

}  // namespace tetragauge
