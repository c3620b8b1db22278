// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/geometry/ply_elements.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "host/base/excerpt.hpp"
#include "host/geometry/parse_number.hpp"

namespace tetragauge {
namespace {

std::optional<PlyScalar> scalar_from_name(std::string_view name) {
  if (name == "char" || name == "int8") return PlyScalar::i8;
  if (name == "uchar" || name == "uint8") return PlyScalar::u8;
  if (name == "short" || name == "int16") return PlyScalar::i16;
  if (name == "ushort" || name == "uint16") return PlyScalar::u16;
  if (name == "int" || name == "int32") return PlyScalar::i32;
  if (name == "uint" || name == "uint32") return PlyScalar::u32;
  if (name == "float" || name == "float32") return PlyScalar::f32;
  if (name == "double" || name == "float64") return PlyScalar::f64;
  return std::nullopt;
}

size_t size_of(PlyScalar type) {
  switch (type) {
    case PlyScalar::i8:
    case PlyScalar::u8:
      return 1;
    case PlyScalar::i16:
    case PlyScalar::u16:
      return 2;
    case PlyScalar::i32:
    case PlyScalar::u32:
    case PlyScalar::f32:
      return 4;
    case PlyScalar::f64:
      return 8;
  }
  return 8;
}

static_assert(std::endian::native == std::endian::little, "the bytes of a number are turned for big endian");

template <class T>
double load(const char* bytes, bool is_big_endian) {
  std::array<char, sizeof(T)> own;
  std::copy_n(bytes, own.size(), own.begin());
  if (is_big_endian) std::reverse(own.begin(), own.end());
  return static_cast<double>(std::bit_cast<T>(own));
}

double load(PlyScalar type, const char* bytes, bool is_big_endian) {
  switch (type) {
    case PlyScalar::i8:
      return load<int8_t>(bytes, is_big_endian);
    case PlyScalar::u8:
      return load<uint8_t>(bytes, is_big_endian);
    case PlyScalar::i16:
      return load<int16_t>(bytes, is_big_endian);
    case PlyScalar::u16:
      return load<uint16_t>(bytes, is_big_endian);
    case PlyScalar::i32:
      return load<int32_t>(bytes, is_big_endian);
    case PlyScalar::u32:
      return load<uint32_t>(bytes, is_big_endian);
    case PlyScalar::f32:
      return load<float>(bytes, is_big_endian);
    case PlyScalar::f64:
      return load<double>(bytes, is_big_endian);
  }
  return 0;
}

std::optional<PlyFormat> format_from_name(std::string_view name) {
  if (name == "ascii") return PlyFormat::ascii;
  if (name == "binary_little_endian") return PlyFormat::binary_little_endian;
  if (name == "binary_big_endian") return PlyFormat::binary_big_endian;
  return std::nullopt;
}

}  // namespace

bool PlyBody::next(PlyScalar type, double& value) {
  if (format_ != PlyFormat::ascii) {
    const size_t size = size_of(type);
    if (bytes_.size() < size) return false;
    value = load(type, bytes_.data(), format_ == PlyFormat::binary_big_endian);
    bytes_.remove_prefix(size);
    return true;
  }
  const size_t start = bytes_.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos) return false;
  const size_t stop = std::min(bytes_.find_first_of(" \t\r\n", start), bytes_.size());
  const std::string_view word = bytes_.substr(start, stop - start);
  bytes_.remove_prefix(stop);
  if (word == "nan" || word == "-nan" || word == "inf" || word == "-inf") {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  const auto number = parse_number<double>(word);
  if (!number) return false;
  value = *number;
  return true;
}

Result<PlyHeader> read_ply_header(std::string_view& rest, const std::string& name) {
  PlyHeader header;
  bool format_seen = false;
  if (next_line(rest).substr(0, 3) != "ply")
    return bad_input(name + ": does not begin with 'ply'; not a PLY file");
  for (int line_number = 2; !rest.empty(); ++line_number) {
    std::string_view line = next_line(rest);
    const std::string place = name + ":" + std::to_string(line_number) + ": ";
    std::string_view after_key = line;
    const std::string_view key = next_word(after_key);
    if (key == "end_header") {
      if (!format_seen) return bad_input(place + "the header has no format line");
      return header;
    }
    if (key == "comment" || key == "obj_info") {
      header.comments.push_back({std::string(after_key), place});
    } else if (key == "format") {
      const std::string_view format = next_word(after_key);
      const auto known = format_from_name(format);
      if (!known) {
        return bad_input(place + "format '" + excerpt(format) +
                         "' is not read; save it as ascii or binary_little_endian");
      }
      header.format = *known;
      format_seen = true;
    } else if (key == "element") {
      PlyElement element;
      element.name = next_word(after_key);
      const auto count = parse_number<uint64_t>(next_word(after_key));
      if (element.name.empty() || !count) return bad_input(place + "expected: element NAME COUNT");
      element.count = *count;
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) return bad_input(place + "a property before the first element");
      PlyProperty property;
      std::string_view type = next_word(after_key);
      if (type == "list") {
        property.count_type = scalar_from_name(next_word(after_key));
        if (!property.count_type) return bad_input(place + "unknown count type of the list");
        type = next_word(after_key);
      }
      const auto scalar = scalar_from_name(type);
      if (!scalar)
        return bad_input(place + "unknown property type '" + excerpt(type) +
                         "'; one of char, uchar, short, ushort, int, uint, float, double");
      property.type = *scalar;
      property.name = next_word(after_key);
      if (property.name.empty()) return bad_input(place + "the property has no name");
      header.elements.back().properties.push_back(std::move(property));
    } else if (!key.empty()) {
      return bad_input(place + "unknown header line '" + excerpt(key) + "'");
    }
  }
  return bad_input(name + ": the header does not end (no end_header); the file is truncated or not PLY");
}

Status check_ply_count(const PlyElement& element, const PlyBody& body, const std::string& name) {
  size_t row_bytes = 0;  // at least
  for (const PlyProperty& property : element.properties) {
    row_bytes += body.format() == PlyFormat::ascii ? 2 : size_of(property.count_type.value_or(property.type));
  }
  const uint64_t rows_possible = row_bytes == 0 ? 0 : (body.bytes_left() + 1) / row_bytes;
  if (element.count <= rows_possible) return Done{};
  return bad_input(name + ": " + std::to_string(element.count) + " of element '" + excerpt(element.name) +
                   "' announced, the file ends after at most " + std::to_string(rows_possible) +
                   "; it is truncated, copy or scan it again");
}

Status check_ply_end(const PlyBody& body, const std::string& name) {
  if (body.is_at_end()) return Done{};
  return bad_input(name + ": " + std::to_string(body.bytes_left()) +
                   " bytes follow after all that the header announces; its counts or types are wrong, " +
                   "export it again");
}

}  // namespace tetragauge
