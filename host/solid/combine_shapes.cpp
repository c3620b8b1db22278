// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/combine_shapes.hpp"

#include <BRepAlgoAPI_BooleanOperation.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_ListOfShape.hxx>

namespace tetragauge {
namespace {

bool is_empty(const TopoDS_Shape& shape) {
  return shape.IsNull() || !TopExp_Explorer(shape, TopAbs_FACE).More();
}

TopoDS_Shape combine(const CsgNode& node, BOPAlgo_Operation operation, const TopoDS_Shape& first,
                     const std::vector<TopoDS_Shape>& rest) {
  TopTools_ListOfShape arguments, tools;
  arguments.Append(first);
  for (const TopoDS_Shape& shape : rest) tools.Append(shape);
  BRepAlgoAPI_BooleanOperation boolean;
  boolean.SetOperation(operation);
  boolean.SetArguments(arguments);
  boolean.SetTools(tools);
  boolean.SetRunParallel(false);  // the order of what it finds must not depend on threads
  boolean.SetNonDestructive(true);
  boolean.Build();
  if (boolean.HasErrors()) {
    throw CsgFailure(node, node.name + ": the exact Boolean failed; shift or simplify its parts");
  }
  const TopoDS_Shape result = boolean.Shape();
  return is_empty(result) ? TopoDS_Shape() : result;
}

}  // namespace

TopoDS_Shape unite(const CsgNode& node, const std::vector<TopoDS_Shape>& shapes) {
  std::vector<TopoDS_Shape> present;
  for (const TopoDS_Shape& shape : shapes) {
    if (!is_empty(shape)) present.push_back(shape);
  }
  if (present.empty()) return {};
  if (present.size() == 1) return present[0];
  return combine(node, BOPAlgo_FUSE, present[0], {present.begin() + 1, present.end()});
}

TopoDS_Shape subtract(const CsgNode& node, const std::vector<TopoDS_Shape>& shapes) {
  if (shapes.empty() || is_empty(shapes[0])) return {};
  std::vector<TopoDS_Shape> tools;
  for (size_t i = 1; i < shapes.size(); ++i) {
    if (!is_empty(shapes[i])) tools.push_back(shapes[i]);
  }
  if (tools.empty()) return shapes[0];
  return combine(node, BOPAlgo_CUT, shapes[0], tools);
}

TopoDS_Shape intersect(const CsgNode& node, const std::vector<TopoDS_Shape>& shapes) {
  if (shapes.empty()) return {};
  TopoDS_Shape result = shapes[0];
  for (size_t i = 1; i < shapes.size(); ++i) {
    if (is_empty(result) || is_empty(shapes[i])) return {};
    result = combine(node, BOPAlgo_COMMON, result, {shapes[i]});
  }
  return result;
}

}  // namespace tetragauge
