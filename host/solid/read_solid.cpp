// SPDX-License-Identifier: GPL-3.0-or-later
#include <BRepBuilderAPI_Transform.hxx>
#include <Standard_Failure.hxx>
#include <algorithm>
#include <cctype>
#include <sstream>

#include "host/base/whole_file.hpp"
#include "host/solid/build_csg.hpp"
#include "host/solid/parse_mesh.hpp"
#include "host/solid/read_step.hpp"
#include "host/solid/solid.hpp"
#include "host/solid/solid_from_mesh.hpp"
#include "host/solid/solid_from_shape.hpp"

namespace tetragauge {
namespace {

// Outside of these a declared unit is more likely wrong than the part that large or small.
constexpr double kLargestLikely_mm = 2000, kSmallestLikely_mm = 1;

Result<Solid> read_step_solid(const std::string& content, const std::string& file,
                              const ReadSolidOptions& options) {
  Result<StepModel> model = read_step(content, file);
  if (!model) return model.error();
  Result<Solid> solid = solid_from_shape(model->shape, file, options);
  if (!solid) return solid;
  solid->declared_unit = model->declared_unit;
  return solid;
}

Result<Solid> read_csg_solid(const std::string& content, const std::string& file,
                             const ReadSolidOptions& options) {
  Result<std::vector<CsgNode>> nodes = parse_csg(content, file);
  if (!nodes) return nodes.error();
  TopoDS_Shape shape;
  try {
    shape = build_csg(std::move(*nodes), options.keep_facets);
  } catch (const CsgFailure& failure) {
    return bad_input(file + ":" + std::to_string(failure.line) + ": " + failure.what());
  }
  const double scale = options.unit_scale_mm.value_or(1.0);
  if (scale != 1.0 && !shape.IsNull()) {
    gp_Trsf T;
    T.SetScaleFactor(scale);
    shape = BRepBuilderAPI_Transform(shape, T, true).Shape();
  }
  return solid_from_shape(shape, file, options);
}

using MeshParser = Result<TriangleMesh> (*)(std::string_view content, const std::string& file);

MeshParser mesh_parser(const std::string& ending) {
  if (ending == ".stl") return parse_stl;
  if (ending == ".obj") return parse_obj;
  if (ending == ".off") return parse_off;
  if (ending == ".ply") return parse_ply_mesh;
  return nullptr;
}

Result<Solid> read_mesh_solid(MeshParser parse, const std::string& content, const std::string& file,
                              const ReadSolidOptions& options) {
  Result<TriangleMesh> mesh = parse(content, file);
  if (!mesh) return mesh.error();
  return solid_from_mesh(std::move(*mesh), file, options);
}

void warn_of_unit(const std::string& file, const ReadSolidOptions& options, Solid& solid) {
  const double size_mm = (solid.box_max_mm - solid.box_min_mm).maxCoeff();
  if (size_mm <= kLargestLikely_mm && size_mm >= kSmallestLikely_mm) return;
  std::ostringstream warning;
  warning << file << ": ";
  if (!solid.declared_unit.empty()) {
    warning << "the declared unit " << solid.declared_unit << " makes the part " << size_mm
            << " mm large; check the unit it was exported with";
  } else {
    warning << "the file states no unit; " << (options.unit_scale_mm ? "the one given" : "taken as mm, it")
            << " makes the part " << size_mm << " mm large; say the right one with --unit";
  }
  solid.warnings.push_back(warning.str());
}

}  // namespace

Result<Solid> read_solid(const std::filesystem::path& path, const ReadSolidOptions& options) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  const bool is_step = ending == ".step" || ending == ".stp";
  const MeshParser parse = mesh_parser(ending);
  if (!is_step && ending != ".csg" && !parse) {
    return bad_input(path.string() + ": '" + ending +
                     "' is not a model this program reads; give .step, .stp, .csg, .stl, .obj, .ply or .off");
  }
  Result<std::string> content = read_whole_file(path);
  if (!content) return content.error();
  try {
    const std::string file = path.string();
    Result<Solid> solid = parse     ? read_mesh_solid(parse, *content, file, options)
                          : is_step ? read_step_solid(*content, file, options)
                                    : read_csg_solid(*content, file, options);
    if (solid) warn_of_unit(file, options, *solid);
    return solid;
  } catch (const Standard_Failure& failure) {
    const char* message = failure.GetMessageString();
    return bad_input(path.string() + ": OpenCASCADE cannot build the model (" +
                     failure.DynamicType()->Name() +
                     (message && *message ? std::string(": ") + message : std::string()) +
                     "); simplify the part or export it again");
  }
}

}  // namespace tetragauge
