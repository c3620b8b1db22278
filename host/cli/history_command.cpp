// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "host/cli/check_outputs.hpp"
#include "host/history/history_file.hpp"
#include "host/history/summary.hpp"
#include "host/report/terminal_text.hpp"

namespace tetragauge::cli {
namespace {

struct Options {
  std::string file, model_hash;
  int face = 0;
  bool ascii = false;
};

// Block characters and colour for a person at a terminal that has them; a pipe or file always gets the same.
HistoryTextOptions text_options(const Options& options) {
  HistoryTextOptions text{.face = options.face};
  if (::isatty(STDOUT_FILENO) == 0) return text;
  text.colour = wants_colour(STDOUT_FILENO);
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const char* const locale = std::getenv(name);
    if (!locale || !*locale) continue;
    const std::string_view value = locale;
    text.unicode = !options.ascii && (value.find("UTF-8") != std::string_view::npos ||
                                      value.find("utf8") != std::string_view::npos);
    break;
  }
  return text;
}

bool has_face(const std::vector<ModelHistory>& models, int id) {
  for (const ModelHistory& model : models)
    for (const FaceHistory& face : model.faces)
      if (face.face == id) return true;
  return false;
}

Result<int> show(const Options& options, const Console& console) {
  if (Status status = check_outputs(console, {}, {options.file}); !status) return status.error();
  Result<HistoryFile> file = HistoryFile::open_to_read(options.file);
  if (!file) return file.error();
  Result<std::vector<PartRecord>> parts = file->parts();
  if (!parts) return parts.error();
  if (parts->empty()) return bad_input(options.file + ": there is no part in it yet");
  std::vector<ModelHistory> models = summarise(*parts);
  std::erase_if(models, [&](const ModelHistory& model) {
    return !std::string_view(model.model_sha256).starts_with(options.model_hash);
  });
  if (models.empty())
    return bad_input(options.file + ": no part of a model whose sha256 begins with " + options.model_hash +
                     "; without --model-hash all models are shown");
  if (options.face != 0 && !has_face(models, options.face))
    return bad_input(options.file + ": no part has a face " + std::to_string(options.face) +
                     "; without --face all faces are shown");
  if (Status status = console.put_json(history_json(models, options.face)); !status) return status.error();
  for (const ModelHistory& model : models)
    console.print((&model == models.data() ? "" : "\n") + history_text(model, text_options(options)));
  return 0;
}

}  // namespace

void add_history(CLI::App& app, Console& console, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "history", "Many parts: statistics, capability and run charts per face");
  command->add_option("history", options->file, "History file that `measure --history` fills (SQLite)")
      ->required()
      ->type_name("DB")
      ->check(not_empty());
  command
      ->add_option("--model-hash", options->model_hash,
                   "Only parts of the model whose sha256 begins so; models are never mixed")
      ->type_name("HEX");
  command->add_option("--face", options->face, "Only this face, with its charts large and its values")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000));
  command->add_flag("--ascii", options->ascii, "Charts without block characters");
  command->footer(
      "Cp and Cpk come with 95 % confidence intervals, and only from 25 parts on. Parts that could not be\n"
      "measured are listed, faces not measured are counted; neither is averaged.");
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> { return show(*options, console); };
  });
}

}  // namespace tetragauge::cli
