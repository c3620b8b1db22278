// SPDX-License-Identifier: GPL-3.0-or-later
// Arguments of one .csg call, typed. Everything that does not fit throws CsgFailure with the call's line.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "host/geometry/vec.hpp"
#include "host/solid/affine.hpp"
#include "host/solid/parse_csg.hpp"

namespace tetragauge {

struct CsgFailure : std::runtime_error {
  CsgFailure(const CsgNode& node, const std::string& what) : std::runtime_error(what), line(node.line) {}
  int line;
};

const CsgValue* find_argument(const CsgNode& node, std::string_view name);  // nullptr if absent or undef
double number_argument(const CsgNode& node, std::string_view name, double otherwise);
double positive_argument(const CsgNode& node, std::string_view name);
bool bool_argument(const CsgNode& node, std::string_view name, bool otherwise);
// A number stands for a vector of equal entries.
std::vector<double> vector_argument(const CsgNode& node, std::string_view name, size_t size);
std::vector<std::vector<double>> rows_argument(const CsgNode& node, std::string_view name, size_t width);
// Lists of indices below `limit`; empty if absent.
std::vector<std::vector<size_t>> index_lists_argument(const CsgNode& node, std::string_view name,
                                                      size_t limit);
Affine matrix_argument(const CsgNode& node);

// Sides of a faceted body of this radius; 0: truly round. $fn of 3 to 36 is a prism, as its author meant; 0
// or more than 36 approximates a round one. With node.keep_facets as many as OpenSCAD makes of $fn, $fa and
// $fs.
size_t facets(const CsgNode& node, double radius_mm);

}  // namespace tetragauge
