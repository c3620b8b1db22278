// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/csg_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/excerpt.hpp"

namespace tetragauge {
namespace {

constexpr double kMostFacets = 36;
constexpr double kMostKeptFacets = 1000;
constexpr double kDefaultFa_deg = 12, kDefaultFs = 2;  // OpenSCAD's own
constexpr double kNoRadius = 0.00001;                  // below it OpenSCAD makes a triangle

// Beyond it no part has a size, and products of such numbers overflow.
constexpr double kLargest = 1e15;

[[noreturn]] void fail(const CsgNode& node, std::string_view name, const std::string& expected) {
  throw CsgFailure(node, excerpt(node.name) + ": '" + excerpt(name) + "' must be " + expected);
}

// nullptr if it is no number of a size that a part can have.
const double* number_of(const CsgValue& value) {
  const double* number = std::get_if<double>(&value.value);
  return number && std::abs(*number) <= kLargest ? number : nullptr;
}

std::vector<double> numbers(const CsgNode& node, std::string_view name, const CsgValue& value, size_t size) {
  const std::string expected = "a list of " + std::to_string(size) + " numbers up to 1e15";
  const CsgList* list = std::get_if<CsgList>(&value.value);
  if (!list || list->size() != size) fail(node, name, expected);
  std::vector<double> result;
  for (const CsgValue& entry : *list) {
    const double* number = number_of(entry);
    if (!number) fail(node, name, expected);
    result.push_back(*number);
  }
  return result;
}

}  // namespace

const CsgValue* find_argument(const CsgNode& node, std::string_view name) {
  for (const auto& [key, value] : node.arguments) {
    if (key == name) return std::holds_alternative<CsgUndef>(value.value) ? nullptr : &value;
  }
  return nullptr;
}

double number_argument(const CsgNode& node, std::string_view name, double otherwise) {
  const CsgValue* value = find_argument(node, name);
  if (!value) return otherwise;
  const double* number = number_of(*value);
  if (!number) fail(node, name, "a number up to 1e15");
  return *number;
}

double positive_argument(const CsgNode& node, std::string_view name) {
  const double number = number_argument(node, name, 0);
  if (!(number > 0)) fail(node, name, "a number above 0");
  return number;
}

bool bool_argument(const CsgNode& node, std::string_view name, bool otherwise) {
  const CsgValue* value = find_argument(node, name);
  if (!value) return otherwise;
  const bool* flag = std::get_if<bool>(&value->value);
  if (!flag) fail(node, name, "true or false");
  return *flag;
}

std::vector<double> vector_argument(const CsgNode& node, std::string_view name, size_t size) {
  const CsgValue* value = find_argument(node, name);
  if (!value) fail(node, name, "given");
  if (const double* number = number_of(*value)) return std::vector<double>(size, *number);
  return numbers(node, name, *value, size);
}

std::vector<std::vector<double>> rows_argument(const CsgNode& node, std::string_view name, size_t width) {
  const CsgValue* value = find_argument(node, name);
  const CsgList* list = value ? std::get_if<CsgList>(&value->value) : nullptr;
  if (!list) fail(node, name, "a list of points");
  std::vector<std::vector<double>> rows;
  for (const CsgValue& row : *list) rows.push_back(numbers(node, name, row, width));
  return rows;
}

std::vector<std::vector<size_t>> index_lists_argument(const CsgNode& node, std::string_view name,
                                                      size_t limit) {
  const CsgValue* value = find_argument(node, name);
  if (!value) return {};
  const std::string expected = "lists of indices below " + std::to_string(limit);
  const CsgList* list = std::get_if<CsgList>(&value->value);
  if (!list) fail(node, name, expected);
  std::vector<std::vector<size_t>> result;
  for (const CsgValue& entry : *list) {
    const CsgList* indices = std::get_if<CsgList>(&entry.value);
    if (!indices) fail(node, name, expected);
    std::vector<size_t>& loop = result.emplace_back();
    for (const CsgValue& index : *indices) {
      const double* number = std::get_if<double>(&index.value);
      if (!number || *number < 0 || *number >= static_cast<double>(limit) || *number != std::floor(*number)) {
        fail(node, name, expected);
      }
      loop.push_back(static_cast<size_t>(*number));
    }
  }
  return result;
}

Affine matrix_argument(const CsgNode& node) {
  const CsgList* rows =
      node.arguments.size() == 1 ? std::get_if<CsgList>(&node.arguments[0].second.value) : nullptr;
  if (!rows || rows->size() != 4) throw CsgFailure(node, "multmatrix: expected one 4 x 4 matrix");
  Affine M;
  for (int i = 0; i < 3; ++i) {
    const std::vector<double> row = numbers(node, "matrix", (*rows)[static_cast<size_t>(i)], 4);
    for (int j = 0; j < 3; ++j) M.A(i, j) = row[static_cast<size_t>(j)];
    M.t[i] = row[3];
  }
  const std::vector<double> last = numbers(node, "matrix", (*rows)[3], 4);
  if (last != std::vector<double>{0, 0, 0, 1}) {
    throw CsgFailure(node, "multmatrix: the last row must be [0, 0, 0, 1]");
  }
  return restore_digits(M);
}

size_t facets(const CsgNode& node, double radius_mm) {
  const double fn = number_argument(node, "$fn", 0);
  if (!node.keep_facets) return fn <= 0 || fn > kMostFacets ? 0 : static_cast<size_t>(std::max(fn, 3.0));
  const double fa = number_argument(node, "$fa", kDefaultFa_deg),
               fs = number_argument(node, "$fs", kDefaultFs);
  // As the OpenSCAD manual says of $fa, $fs and $fn.
  double count = 3;
  if (fn > 0) {
    count = std::max(fn, 3.0);
  } else if (radius_mm > kNoRadius) {
    count = std::ceil(std::max(std::min(360 / fa, radius_mm * 2 * std::numbers::pi / fs), 5.0));
  }
  if (!(count <= kMostKeptFacets)) {
    throw CsgFailure(node, node.name + ": more than " + std::to_string(static_cast<int>(kMostKeptFacets)) +
                               " facets to a turn; leave out --facets or lower $fn");
  }
  return static_cast<size_t>(count);
}

}  // namespace tetragauge
