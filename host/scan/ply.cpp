// SPDX-License-Identifier: GPL-3.0-or-later
// Polygon File Format, "The PLY Polygon File Format", Turk 1994: reading of vertex and rejected elements,
// writing of scans.
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "host/geometry/face_list_file.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/scan/point_table.hpp"
#include "host/scan/scan_file.hpp"

namespace tetragauge {
namespace {

static_assert(std::endian::native == std::endian::little,
              "scan files are read and written as they lie in memory");

enum class Scalar { i8, u8, i16, u16, i32, u32, f32, f64 };

struct Property {
  std::string name;
  Scalar type = Scalar::f64;
  std::optional<Scalar> count_type;  // set for a list
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

std::optional<Scalar> scalar_from_name(std::string_view name) {
  if (name == "char" || name == "int8") return Scalar::i8;
  if (name == "uchar" || name == "uint8") return Scalar::u8;
  if (name == "short" || name == "int16") return Scalar::i16;
  if (name == "ushort" || name == "uint16") return Scalar::u16;
  if (name == "int" || name == "int32") return Scalar::i32;
  if (name == "uint" || name == "uint32") return Scalar::u32;
  if (name == "float" || name == "float32") return Scalar::f32;
  if (name == "double" || name == "float64") return Scalar::f64;
  return std::nullopt;
}

size_t size_of(Scalar type) {
  switch (type) {
    case Scalar::i8:
    case Scalar::u8:
      return 1;
    case Scalar::i16:
    case Scalar::u16:
      return 2;
    case Scalar::i32:
    case Scalar::u32:
    case Scalar::f32:
      return 4;
    case Scalar::f64:
      return 8;
  }
  return 8;
}

template <class T>
double load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double load(Scalar type, const char* bytes) {
  switch (type) {
    case Scalar::i8:
      return load<int8_t>(bytes);
    case Scalar::u8:
      return load<uint8_t>(bytes);
    case Scalar::i16:
      return load<int16_t>(bytes);
    case Scalar::u16:
      return load<uint16_t>(bytes);
    case Scalar::i32:
      return load<int32_t>(bytes);
    case Scalar::u32:
      return load<uint32_t>(bytes);
    case Scalar::f32:
      return load<float>(bytes);
    case Scalar::f64:
      return load<double>(bytes);
  }
  return 0;
}

// The numbers of the body one after the other, binary or text.
class Body {
 public:
  Body(std::string_view bytes, bool binary) : bytes_(bytes), binary_(binary) {}

  bool next(Scalar type, double& value) {
    if (binary_) {
      const size_t size = size_of(type);
      if (bytes_.size() < size) return false;
      value = load(type, bytes_.data());
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
  size_t bytes_left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
  bool binary_;
};

Status read_comment(std::string_view comment, const std::string& place, PointTable& table) {
  const std::string_view key = next_word(comment);
  const size_t start = comment.find_first_not_of(" \t");
  std::string value(start == std::string_view::npos ? std::string_view{} : comment.substr(start));
  while (!value.empty() && (value.back() == '\r' || value.back() == ' ')) value.pop_back();
  ScanHeader& header = table.header;
  if (key == "frame") header.frame = value;
  if (key == "machine_id") header.machine_id = value;
  if (key == "calibration_id") header.calibration_id = value;
  if (key == "part_serial") header.part_serial = value;
  if (key == "operator") header.operator_name = value;
  if (key == "start_time") header.start_time = value;
  if (key == "unit") {
    const Result<double> unit = unit_mm(value);
    if (!unit) return bad_input(place + unit.error().message);
    table.unit_scale_mm = *unit;
  }
  if (key == "u_cal_mm") {
    const auto number = parse_number<double>(value);
    if (!number) return bad_input(place + "u_cal_mm is not a number");
    header.u_cal_mm = *number;
  }
  if (key == "seed") {
    const auto number = parse_number<uint64_t>(value);
    if (!number) return bad_input(place + "seed is not a whole number");
    header.seed = *number;
  }
  return Done{};
}

struct Header {
  std::vector<Element> elements;
  bool binary = false;
};

Result<Header> read_header(std::string_view& rest, const std::string& name, PointTable& table) {
  Header header;
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
      if (Status status = read_comment(after_key, place, table); !status) return status.error();
    } else if (key == "format") {
      const std::string_view format = next_word(after_key);
      if (format != "ascii" && format != "binary_little_endian") {
        return bad_input(place + "format '" + std::string(format) +
                         "' is not read; save it as ascii or binary_little_endian");
      }
      header.binary = format != "ascii";
      format_seen = true;
    } else if (key == "element") {
      Element element;
      element.name = next_word(after_key);
      const auto count = parse_number<uint64_t>(next_word(after_key));
      if (element.name.empty() || !count) return bad_input(place + "expected: element NAME COUNT");
      element.count = *count;
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) return bad_input(place + "a property before the first element");
      Property property;
      std::string_view type = next_word(after_key);
      if (type == "list") {
        property.count_type = scalar_from_name(next_word(after_key));
        if (!property.count_type) return bad_input(place + "unknown count type of the list");
        type = next_word(after_key);
      }
      const auto scalar = scalar_from_name(type);
      if (!scalar) return bad_input(place + "unknown property type '" + std::string(type) + "'");
      property.type = *scalar;
      property.name = next_word(after_key);
      if (property.name.empty()) return bad_input(place + "the property has no name");
      header.elements.back().properties.push_back(std::move(property));
    } else if (!key.empty()) {
      return bad_input(place + "unknown header line '" + std::string(key.substr(0, 40)) + "'");
    }
  }
  return bad_input(name + ": the header does not end (no end_header); the file is truncated or not PLY");
}

Result<std::vector<RejectedBeam>> rejected_from(const std::map<std::string, std::vector<double>>& columns,
                                                size_t count, const std::string& name) {
  std::vector<RejectedBeam> beams(count);
  const auto at = [&](const char* key, size_t i) {
    const auto found = columns.find(key);
    return found == columns.end() ? std::numeric_limits<double>::quiet_NaN() : found->second[i];
  };
  for (size_t i = 0; i < count; ++i) {
    RejectedBeam& beam = beams[i];
    beam.origin = {at("origin_x", i), at("origin_y", i), at("origin_z", i)};
    beam.direction = {at("direction_x", i), at("direction_y", i), at("direction_z", i)};
    const double reason = at("reason", i), view = at("view", i);
    if (!beam.origin.allFinite() || !(std::abs(beam.direction.norm() - 1) < 1e-3) ||
        !(reason >= 0 && reason < 4294967296.0) || !(view >= 0 && view < 4294967296.0)) {
      return bad_input(name + ": rejected beam " + std::to_string(i) +
                       ": expected origin_x/y/z, a unit direction_x/y/z, reason and view");
    }
    beam.reason = static_cast<uint32_t>(reason);
    beam.view = static_cast<uint32_t>(view);
  }
  return beams;
}

}  // namespace

Result<PointTable> parse_ply(std::string_view content, const std::string& name) {
  PointTable table;
  std::string_view rest = content;
  Result<Header> header = read_header(rest, name, table);
  if (!header) return header.error();
  Body body(rest, header->binary);
  bool vertices_seen = false;
  for (const Element& element : header->elements) {
    size_t row_bytes = 0;  // at least
    for (const Property& property : element.properties) {
      row_bytes += header->binary ? size_of(property.count_type.value_or(property.type)) : 2;
    }
    const uint64_t rows_possible = row_bytes == 0 ? 0 : (body.bytes_left() + 1) / row_bytes;
    if (element.count > rows_possible) {
      return bad_input(name + ": " + std::to_string(element.count) + " of element '" + element.name +
                       "' announced, the file ends after at most " + std::to_string(rows_possible) +
                       "; it is truncated, copy or scan it again");
    }
    std::map<std::string, std::vector<double>> columns;
    std::vector<std::vector<double>*> order;
    for (const Property& property : element.properties) {
      if (property.count_type) {
        order.push_back(nullptr);
        continue;
      }
      auto [entry, is_new] = columns.try_emplace(property.name);
      if (!is_new)
        return bad_input(name + ": property '" + property.name + "' of '" + element.name +
                         "' stands there twice");
      entry->second.reserve(element.count);
      order.push_back(&entry->second);
    }
    for (uint64_t row = 0; row < element.count; ++row) {
      const auto broken = [&] {
        return bad_input(name + ": " + element.name + " " + std::to_string(row) + ": " +
                         (body.bytes_left() == 0 ? "the file ends here; it is truncated"
                                                 : "not a number, or the file ends within it"));
      };
      for (size_t k = 0; k < order.size(); ++k) {
        const Property& property = element.properties[k];
        double value = 0;
        if (!body.next(property.count_type.value_or(property.type), value)) return broken();
        if (!property.count_type) {
          order[k]->push_back(value);
          continue;
        }
        if (!(value >= 0)) return broken();
        for (double i = 0, item = 0; i < value; ++i) {
          if (!body.next(property.type, item)) return broken();
        }
      }
    }
    if (element.name == "vertex") {
      vertices_seen = true;
      table.rows = element.count;
      table.columns = std::move(columns);
    } else if (element.name == "rejected") {
      Result<std::vector<RejectedBeam>> beams = rejected_from(columns, element.count, name);
      if (!beams) return beams.error();
      table.rejected = std::move(*beams);
    }
  }
  if (!vertices_seen) return bad_input(name + ": no element 'vertex'; there are no points in it");
  return table;
}

std::string scan_to_ply(const Scan& scan) {
  std::string ply = "ply\nformat binary_little_endian 1.0\n";
  const auto comment = [&](const char* key, const std::string& value) {
    if (value.empty()) return;
    std::string line = value;
    for (char& c : line) c = c == '\n' || c == '\r' ? ' ' : c;
    ply += std::string("comment ") + key + " " + line + "\n";
  };
  const ScanHeader& header = scan.header;
  comment("frame", header.frame);
  comment("unit", "mm");
  comment("machine_id", header.machine_id);
  comment("calibration_id", header.calibration_id);
  std::array<char, 32> number;
  const auto end = std::to_chars(number.data(), number.data() + number.size(), header.u_cal_mm).ptr;
  comment("u_cal_mm", std::string(number.data(), end));
  if (header.seed) comment("seed", std::to_string(*header.seed));
  comment("part_serial", header.part_serial);
  comment("operator", header.operator_name);
  comment("start_time", header.start_time);
  ply += "element vertex " + std::to_string(scan.size()) + "\n";
  for (const char* property : {"x", "y", "z", "ray_x", "ray_y", "ray_z"})
    ply += std::string("property double ") + property + "\n";
  ply += "property float sigma\nproperty float intensity\nproperty uint view\nproperty uint flags\n";
  ply += "element rejected " + std::to_string(scan.rejected.size()) + "\n";
  for (const char* property :
       {"origin_x", "origin_y", "origin_z", "direction_x", "direction_y", "direction_z"}) {
    ply += std::string("property double ") + property + "\n";
  }
  ply += "property uint reason\nproperty uint view\nend_header\n";

  const auto put = [&](const auto& value) {
    ply.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  ply.reserve(ply.size() + scan.size() * 64 + scan.rejected.size() * 56);
  for (size_t i = 0; i < scan.size(); ++i) {
    for (int k = 0; k < 3; ++k) put(scan.points[i][k]);
    for (int k = 0; k < 3; ++k) put(scan.ray_origins[i][k]);
    put(scan.sigma_mm[i]);
    put(scan.intensity[i]);
    put(scan.view[i]);
    put(scan.flags[i]);
  }
  for (const RejectedBeam& beam : scan.rejected) {
    for (int k = 0; k < 3; ++k) put(beam.origin[k]);
    for (int k = 0; k < 3; ++k) put(beam.direction[k]);
    put(beam.reason);
    put(beam.view);
  }
  return ply;
}

}  // namespace tetragauge
