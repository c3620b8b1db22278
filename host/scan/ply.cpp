// SPDX-License-Identifier: GPL-3.0-or-later
// Scans as PLY: the vertex and rejected elements read, and scans written.
#include <array>
#include <bit>
#include <limits>

#include "host/base/excerpt.hpp"
#include "host/geometry/face_list_file.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/geometry/ply_elements.hpp"
#include "host/scan/point_table.hpp"
#include "host/scan/scan_file.hpp"

namespace tetragauge {
namespace {

static_assert(std::endian::native == std::endian::little, "scan files are written as they lie in memory");

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
  if (key == "spot_mm") {
    const auto number = parse_number<double>(value);
    if (!number) return bad_input(place + "spot_mm is not a number");
    header.spot_mm = *number;
  }
  if (key == "seed") {
    const auto number = parse_number<uint64_t>(value);
    if (!number) return bad_input(place + "seed is not a whole number");
    header.seed = *number;
  }
  return Done{};
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
  Result<PlyHeader> header = read_ply_header(rest, name);
  if (!header) return header.error();
  for (const PlyComment& comment : header->comments) {
    if (Status status = read_comment(comment.text, comment.place, table); !status) return status.error();
  }
  PlyBody body(rest, header->format);
  bool vertices_seen = false;
  for (const PlyElement& element : header->elements) {
    if (Status status = check_ply_count(element, body, name); !status) return status.error();
    std::map<std::string, std::vector<double>> columns;
    std::vector<std::vector<double>*> order;
    for (const PlyProperty& property : element.properties) {
      if (property.count_type) {
        order.push_back(nullptr);
        continue;
      }
      auto [entry, is_new] = columns.try_emplace(property.name);
      if (!is_new)
        return bad_input(name + ": property '" + excerpt(property.name) + "' of '" + excerpt(element.name) +
                         "' stands there twice; rename one");
      entry->second.reserve(element.count);
      order.push_back(&entry->second);
    }
    for (uint64_t row = 0; row < element.count; ++row) {
      const auto broken = [&] {
        return bad_input(name + ": " + excerpt(element.name) + " " + std::to_string(row) + ": " +
                         (body.bytes_left() == 0 ? "the file ends here; it is truncated"
                                                 : "not a number, or the file ends within it") +
                         ", copy or scan it again");
      };
      for (size_t k = 0; k < order.size(); ++k) {
        const PlyProperty& property = element.properties[k];
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
      if (vertices_seen) return bad_input(name + ": element 'vertex' stands there twice; export it again");
      vertices_seen = true;
      table.rows = element.count;
      table.columns = std::move(columns);
    } else if (element.name == "rejected") {
      Result<std::vector<RejectedBeam>> beams = rejected_from(columns, element.count, name);
      if (!beams) return beams.error();
      table.rejected = std::move(*beams);
    }
  }
  if (Status status = check_ply_end(body, name); !status) return status.error();
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
  const auto shortest = [](double value) {
    std::array<char, 32> number;
    return std::string(number.data(), std::to_chars(number.data(), number.data() + number.size(), value).ptr);
  };
  comment("u_cal_mm", shortest(header.u_cal_mm));
  if (header.spot_mm > 0) comment("spot_mm", shortest(header.spot_mm));
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
