// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>

#include "host/base/whole_file.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/cli/face_table.hpp"
#include "host/cli/input_options.hpp"
#include "host/faces/draw_faces.hpp"
#include "host/faces/find_faces.hpp"
#include "host/geometry/face_list_file.hpp"

namespace tetragauge::cli {
namespace {

struct Options {
  InputOptions input;
  FindFacesOptions faces;
  std::string dendrogram, out;
};

constexpr const char* kOutputs[] = {"surface.ply", "views.png", "gaussian-sphere.png"};

std::string in_folder(const std::string& folder, const char* name) {
  return (std::filesystem::path(folder) / name).string();
}

Status prepare_outputs(const Console& console, const Options& options) {
  std::vector<std::string> outputs;
  if (!options.dendrogram.empty()) outputs.push_back(options.dendrogram);
  if (!options.out.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return usage_error(options.out + ": the folder cannot be made: " + error.message());
    for (const char* name : kOutputs) outputs.push_back(in_folder(options.out, name));
  }
  return check_outputs(console, outputs, {options.input.scan});
}

// The list, and to each face its loops: corners in order, and the face beyond the edge that begins there (0:
// none, the rim of what was measured).
nlohmann::ordered_json faces_json(const MeasuredFaces& faces) {
  nlohmann::ordered_json json = face_list_to_json(faces.list, "tetragauge/faces/1");
  for (size_t k = 0; k < faces.boundaries.size(); ++k) {
    auto& loops = json["faces"][k]["boundary"] = nlohmann::ordered_json::array();
    for (const BoundaryLoop& loop : faces.boundaries[k]) {
      nlohmann::ordered_json edges = nlohmann::ordered_json::array();
      for (const BoundaryEdge& edge : loop)
        edges.push_back({{"corner_mm", {edge.from_mm.x(), edge.from_mm.y(), edge.from_mm.z()}},
                         {"beyond", edge.beyond + 1}});
      loops.push_back(std::move(edges));
    }
  }
  json["volume_mm3"] = faces.volume_mm3;
  json["points_used"] = faces.points_used;
  json["points_rejected"] = faces.points_rejected;
  json["false_chamfers_dropped"] = faces.false_chamfers_dropped;
  return json;
}

Status write_outputs(const Options& options, const Reconstruction& reconstruction,
                     const MeasuredFaces& faces) {
  if (!options.dendrogram.empty()) {
    if (Status status = write_whole_file(options.dendrogram, dendrogram_to_csv(faces.dendrogram)); !status)
      return status;
  }
  if (options.out.empty()) return Done{};
  const std::string contents[] = {coloured_surface_ply(reconstruction, faces),
                                  draw_four_views(reconstruction, faces).png(),
                                  draw_gaussian_sphere(faces).png()};
  for (size_t k = 0; k < std::size(contents); ++k) {
    if (Status status = write_whole_file(in_folder(options.out, kOutputs[k]), contents[k]); !status)
      return status;
  }
  return Done{};
}

Result<int> run_faces(const Options& options, const Console& console) {
  if (Status status = prepare_outputs(console, options); !status) return status.error();
  Result<Scan> scan = options.input.read_scan(console);
  if (!scan) return scan.error();
  Result<Reconstruction> reconstruction = reconstruct(*scan);
  if (!reconstruction) return reconstruction.error();
  Result<MeasuredFaces> faces = find_faces(*scan, *reconstruction, options.faces);
  if (!faces) return faces.error();
  if (Status status = write_outputs(options, *reconstruction, *faces); !status) return status.error();
  if (Status status = console.put_json(faces_json(*faces)); !status) return status.error();
  console.print(face_table(faces->list));
  console.say(std::to_string(faces->points_used) + " points on " + std::to_string(faces->faces().size()) +
              " faces, " + std::to_string(faces->points_rejected) + " on none");
  return 0;
}

}  // namespace

void add_faces(CLI::App& app, Console& console, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "faces", "The real faces of the part, each fitted to all its points");
  options->input.add_scan(*command);
  options->input.add_unit(*command);
  command
      ->add_option("--cluster", options->faces.cluster,
                   "grow: regions on the surface; normals, slink: the thesis's clustering of triangles")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, ClusterMethod>{{"grow", ClusterMethod::grow},
                                                                       {"normals", ClusterMethod::normals},
                                                                       {"slink", ClusterMethod::slink}})
              .description(""))
      ->type_name("METHOD")
      ->default_str("grow");
  command
      ->add_option("--neighbour-weight", options->faces.neighbour_weight,
                   "normals, slink: of a triangle's neighbours in the correction of its normal")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  auto* height = command
                     ->add_option("--height", options->faces.single_link.height,
                                  "slink: where to cut the dendrogram, rad (0: from the noise)")
                     ->check(CLI::NonNegativeNumber);
  auto* count = command
                    ->add_option("--count", options->faces.single_link.count,
                                 "slink: cut it where it has this many coplanar clusters")
                    ->excludes(height)
                    ->check(CLI::PositiveNumber);
  auto* dendrogram = command->add_option("--dendrogram", options->dendrogram, "slink: the merges, as CSV")
                         ->type_name("FILE")
                         ->check(not_empty());
  command->add_option("--out", options->out, "Folder for surface.ply, views.png and gaussian-sphere.png")
      ->type_name("DIR")
      ->check(not_empty());
  command->callback([options, &console, &run, height, count, dendrogram] {
    if (options->faces.cluster != ClusterMethod::slink) {
      for (const CLI::Option* only : {height, count, dendrogram}) {
        if (only->count() > 0) throw CLI::ValidationError(only->get_name(), "goes with --cluster slink only");
      }
    }
    run = [options, &console] { return run_faces(*options, console); };
  });
}

}  // namespace tetragauge::cli
