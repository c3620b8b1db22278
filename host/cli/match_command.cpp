// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/check_outputs.hpp"
#include "host/cli/input_options.hpp"
#include "host/cli/match_text.hpp"
#include "host/geometry/face_list_file.hpp"
#include "host/match/pair_rules_file.hpp"
#include "host/report/report.hpp"

namespace tetragauge::cli {
namespace {

struct Options {
  InputOptions input;
  std::string measured, pairs, method = "search", links = "all";
  MatchOptions match;
};

// What either method gives, for the page and for the file.
struct Answer {
  Match match;
  nlohmann::ordered_json json;
  std::string text;
};

Result<FaceList> read_model_faces(const Options& options, const Console& console) {
  const std::string& name = options.input.model;
  if (name.ends_with(".hsp") || name.ends_with(".json")) {
    const Result<double> unit = options.input.model_unit_mm();
    if (!unit) return unit.error();
    return read_face_list(name, *unit);
  }
  Result<Solid> solid = options.input.read_model(console);
  if (!solid) return solid.error();
  return std::move(solid->list);
}

Result<Answer> answer(const FaceList& model, const FaceList& measured, const Options& options,
                      const PairRules& rules) {
  if (options.method == "procrustes") {
    ProcrustesOptions how;
    how.links = options.links == "modes" ? ProcrustesOptions::Links::modes : ProcrustesOptions::Links::all;
    how.rules = rules;
    const Result<ProcrustesMatch> found = match_procrustes(model, measured, how);
    if (!found) return found.error();
    return Answer{found->match, procrustes_json(*found), procrustes_text(*found)};
  }
  MatchOptions how = options.match;
  how.rules = rules;
  const Result<Match> found = match_face_lists(model, measured, how);
  if (!found) return found.error();
  return Answer{*found, match_json(*found, "search"), match_text(*found)};
}

Result<int> match_files(const Options& options, const Console& console) {
  if (Status status = check_outputs(console, {}, {options.input.model, options.measured, options.pairs});
      !status)
    return status.error();
  const Result<FaceList> model = read_model_faces(options, console);
  if (!model) return model.error();
  const Result<double> unit = options.input.unit.empty() ? Result<double>(1.0) : unit_mm(options.input.unit);
  if (!unit) return unit.error();
  const Result<FaceList> measured = read_face_list(options.measured, *unit);
  if (!measured) return measured.error();
  PairRules rules;
  if (!options.pairs.empty()) {
    Result<PairRules> read = read_pair_rules(options.pairs);
    if (!read) return read.error();
    rules = std::move(*read);
  }

  Result<Answer> found = answer(*model, *measured, options, rules);
  if (!found) return found.error();
  if (!options.pairs.empty()) {
    const Result<Answer> without = answer(*model, *measured, options, {});
    if (without) {
      const PairChanges changes = pair_changes(without->match, found->match);
      found->json["changes"] = pair_changes_json(changes);
      found->text += pair_changes_text(changes);
    } else {
      found->text += "without the fixed and forbidden pairs: " + without.error().message + "\n";
    }
  }
  if (Status status = console.put_json(found->json); !status) return status.error();
  console.print(found->text);
  return 0;
}

}  // namespace

void add_match(CLI::App& app, Console& console, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "match", "Measured faces against a model's, with no initial pose");
  command
      ->add_option("--model", options->input.model,
                   std::string("Solid model (") + kModelFiles + ") or a list (.hsp .json)")
      ->required()
      ->type_name("MODEL");
  options->input.add_facets(*command);
  command->add_option("--measured", options->measured, "Faces as `faces --json` writes them, or a list .hsp")
      ->required()
      ->type_name("FACES");
  command->add_flag("--unsigned", options->match.is_unsigned, "Normals do not tell the side of the material");
  command
      ->add_option(
          "--method", options->method,
          "search: every pose from pairs of directions; procrustes: the thesis's, on normals scaled by "
          "distance and area (their sense never counts)")
      ->check(CLI::IsMember({"search", "procrustes"}))
      ->capture_default_str();
  CLI::Option* links =
      command
          ->add_option("--links", options->links,
                       "Of procrustes, after each turn: break all links, or those beyond the modes of their "
                       "lengths")
          ->check(CLI::IsMember({"all", "modes"}))
          ->capture_default_str();
  command
      ->add_option(
          "--pairs", options->pairs,
          "Pairs that must be or must not be: {\"fix\": [[model, measured], ...], \"forbid\": [...]}")
      ->type_name("FILE");
  options->input.add_unit(*command);
  command->callback([options, links, &console, &run] {
    if (links->count() > 0 && options->method != "procrustes")
      throw CLI::ValidationError("--links", "goes with --method procrustes");
    run = [options, &console] { return match_files(*options, console); };
  });
}

}  // namespace tetragauge::cli
