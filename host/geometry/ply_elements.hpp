// SPDX-License-Identifier: GPL-3.0-or-later
// Polygon File Format (Turk, "The PLY Polygon File Format", 1994): the header, and the numbers behind it one
// after the other. What the elements mean is the caller's: a scan, or a mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/result.hpp"

namespace tetragauge {

enum class PlyScalar { i8, u8, i16, u16, i32, u32, f32, f64 };
enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

struct PlyProperty {
  std::string name;
  PlyScalar type = PlyScalar::f64;
  std::optional<PlyScalar> count_type;  // set for a list
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyComment {
  std::string text;   // without the word `comment`
  std::string place;  // "file:line: ", for errors about it
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::vector<PlyComment> comments;
};

// Takes the header off `rest`. Errors name the file and line.
Result<PlyHeader> read_ply_header(std::string_view& rest, const std::string& name);

class PlyBody {
 public:
  PlyBody(std::string_view bytes, PlyFormat format) : bytes_(bytes), format_(format) {}

  // The next number; NaN and infinity come as NaN. False where the file ends or has none.
  bool next(PlyScalar type, double& value);
  size_t bytes_left() const { return bytes_.size(); }
  // Whether nothing but blanks and line ends is left.
  bool is_at_end() const { return bytes_.find_first_not_of(" \t\r\n") == std::string_view::npos; }
  PlyFormat format() const { return format_; }

 private:
  std::string_view bytes_;
  PlyFormat format_;
};

// An error if the rest of the file cannot hold what the header announces: no memory is asked for it then.
Status check_ply_count(const PlyElement& element, const PlyBody& body, const std::string& name);

// After the last element: an error if more follows than the header announces.
Status check_ply_end(const PlyBody& body, const std::string& name);

}  // namespace tetragauge
