// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/excerpt.hpp"
#include "host/geometry/parse_number.hpp"
#include "host/scan/point_table.hpp"

namespace tetragauge {
namespace {

// Reads the rest of `text` as rows of `names.size()` numbers; returns how many, those not finite included.
Result<size_t> read_rows(std::string_view text, int line_number, const std::vector<std::string>& names,
                         bool skip_not_finite, const std::string& file, PointTable& table) {
  std::vector<std::vector<double>*> columns;
  for (const std::string& name : names) {
    const auto [column, is_new] = table.columns.try_emplace(name);
    if (!is_new) return bad_input(file + ": column '" + excerpt(name) + "' stands there twice; rename one");
    columns.push_back(&column->second);
  }
  size_t rows = 0;
  std::vector<double> row(names.size());
  for (; !text.empty(); ++line_number) {
    std::string_view line = next_line(text);
    const std::string place = file + ":" + std::to_string(line_number) + ": ";
    std::string_view word = next_word(line);
    if (word.empty() || word.front() == '#') continue;
    bool whole_row = true;
    ++rows;
    for (size_t k = 0; k < row.size(); ++k, word = next_word(line)) {
      const auto value = parse_number<double>(word);
      if (!value && skip_not_finite && (word == "nan" || word == "-nan")) {
        whole_row = false;  // PCD marks a pixel that saw nothing so
        continue;
      }
      if (!value) {
        return bad_input(place +
                         (word.empty() ? "the line ends after " + std::to_string(k) + " of " +
                                             std::to_string(row.size()) + " numbers"
                                       : "'" + excerpt(word) + "' is not a finite number") +
                         "; repair or remove the line");
      }
      row[k] = *value;
    }
    if (!word.empty())
      return bad_input(place + "more than " + std::to_string(row.size()) +
                       " numbers in the line; repair or remove it");
    if (!whole_row) continue;
    for (size_t k = 0; k < row.size(); ++k) columns[k]->push_back(row[k]);
    ++table.rows;
  }
  return rows;
}

}  // namespace

Result<PointTable> parse_xyz(std::string_view content, const std::string& name) {
  PointTable table;
  std::vector<std::string> names;
  std::string_view rest = content;
  int line_number = 1;
  while (names.empty() && !rest.empty()) {
    const std::string_view before = rest;
    std::string_view line = next_line(rest);
    std::string_view word = next_word(line);
    if (word.empty() || word.front() == '#') {
      ++line_number;
      continue;
    }
    const bool has_header = !parse_number<double>(word) && word != "nan";
    size_t count = 0;
    for (; !word.empty(); word = next_word(line), ++count) {
      if (has_header) names.emplace_back(word);
    }
    if (has_header) {
      ++line_number;
      break;
    }
    rest = before;
    names = {"x", "y", "z"};
    if (count == 6) names.insert(names.end(), {"nx", "ny", "nz"});
    if (count > 3 && count != 6) {
      for (size_t k = 3; k < count; ++k) names.push_back("column" + std::to_string(k + 1));
    }
  }
  const Result<size_t> rows = read_rows(rest, line_number, names, false, name, table);
  if (!rows) return rows.error();
  return table;
}

Result<PointTable> parse_pcd(std::string_view content, const std::string& name) {
  PointTable table;
  std::vector<std::string> names;
  size_t points = 0;
  bool points_given = false;
  for (int line_number = 1; !content.empty(); ++line_number) {
    std::string_view line = next_line(content);
    const std::string place = name + ":" + std::to_string(line_number) + ": ";
    const std::string_view key = next_word(line);
    if (key == "FIELDS") {
      for (auto word = next_word(line); !word.empty(); word = next_word(line)) {
        names.emplace_back(word == "normal_x"   ? "nx"
                           : word == "normal_y" ? "ny"
                           : word == "normal_z" ? "nz"
                                                : word);
      }
    } else if (key == "COUNT") {
      for (auto word = next_word(line); !word.empty(); word = next_word(line)) {
        if (word != "1")
          return bad_input(place + "fields of more than one number are not read; save it as PLY");
      }
    } else if (key == "POINTS") {
      const auto value = parse_number<size_t>(next_word(line));
      if (!value) return bad_input(place + "POINTS is not a whole number");
      points = *value;
      points_given = true;
    } else if (key == "DATA") {
      if (next_word(line) != "ascii")
        return bad_input(place + "only DATA ascii is read; convert it, or save it as PLY");
      if (names.empty()) return bad_input(place + "DATA comes before FIELDS");
      const Result<size_t> rows = read_rows(content, line_number + 1, names, true, name, table);
      if (!rows) return rows.error();
      if (points_given && *rows != points) {
        return bad_input(name + ": " + std::to_string(points) + " points announced, " +
                         std::to_string(*rows) + " there; the file is " +
                         (*rows < points ? "truncated" : "damaged") + ", copy or export it again");
      }
      return table;
    }
  }
  return bad_input(name + ": no DATA line; not a PCD file, or one cut short");
}

}  // namespace tetragauge
