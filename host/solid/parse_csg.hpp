// SPDX-License-Identifier: GPL-3.0-or-later
// The text of a .csg file as a tree of calls: name(arguments) { children }, each with its line.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "host/base/result.hpp"

namespace tetragauge {

struct CsgValue;
using CsgList = std::vector<CsgValue>;
struct CsgUndef {};

struct CsgValue {
  std::variant<CsgUndef, bool, double, std::string, CsgList> value;
};

struct CsgNode {
  std::string name;
  int line = 0;              // from 1
  bool keep_facets = false;  // round bodies as OpenSCAD's facets; set by whoever builds the shape
  std::vector<std::pair<std::string, CsgValue>> arguments;
  std::vector<CsgNode> children;
};

// The top-level calls. Subtrees marked % (background) or * (disabled) are left out, # (highlight) is ignored,
// as OpenSCAD's own rendering does. Errors name file and line.
Result<std::vector<CsgNode>> parse_csg(std::string_view text, const std::string& file);

}  // namespace tetragauge
