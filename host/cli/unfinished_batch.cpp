// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/unfinished_batch.hpp"

#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"

namespace tetragauge::cli {
namespace {

constexpr const char* kSchema = "tetragauge/batch/1";

}  // namespace

std::filesystem::path UnfinishedBatch::path_in(const std::filesystem::path& folder) {
  return folder / "unfinished-batch.json";
}

Result<UnfinishedBatch> UnfinishedBatch::begin(const std::filesystem::path& folder,
                                               const nlohmann::ordered_json& order) {
  UnfinishedBatch batch;
  batch.path_ = path_in(folder);
  batch.order_ = order;
  if (Status written = batch.write(); !written) return written.error();
  return batch;
}

Result<UnfinishedBatch> UnfinishedBatch::reopen(const std::filesystem::path& folder,
                                                const nlohmann::ordered_json& order) {
  UnfinishedBatch batch;
  batch.path_ = path_in(folder);
  batch.order_ = order;
  std::error_code ignored;
  if (!std::filesystem::exists(batch.path_, ignored))
    return bad_input(batch.path_.string() +
                     ": there is no batch that was broken off; measure without --resume");
  const Result<std::string> text = read_whole_file(batch.path_);
  if (!text) return text.error();
  const auto json = parse_json(*text, batch.path_.string());
  if (!json) return json.error();
  const Error damaged =
      bad_input(batch.path_.string() + ": not the file of a batch; move it away and measure anew");
  try {
    if (json->at("schema") != kSchema) return damaged;
    for (const auto& [option, value] : order.items()) {
      if (json->at("order").at(option) != value)
        return bad_input(batch.path_.string() + ": the batch was begun with another " + option +
                         "; repeat its command, or move that file away to begin anew");
    }
    batch.begun_ = json->at("begun").get<std::string>();
    for (const auto& part : json->at("finished"))
      batch.finished_[part.at("part").get<std::string>()] = {part.at("number").get<int64_t>(),
                                                             part.at("exit_code").get<int>()};
  } catch (const nlohmann::json::exception&) {
    return damaged;
  }
  return batch;
}

Status UnfinishedBatch::begin_part(const std::string& part) {
  begun_ = part;
  return write();
}

Status UnfinishedBatch::end_part(const std::string& part, const FinishedPart& finished) {
  begun_.clear();
  finished_[part] = finished;
  return write();
}

void UnfinishedBatch::remove() const {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

Status UnfinishedBatch::write() const {
  nlohmann::ordered_json json{
      {"schema", kSchema}, {"order", order_}, {"begun", begun_}, {"finished", nlohmann::json::array()}};
  for (const auto& [part, finished] : finished_)
    json["finished"].push_back(
        {{"part", part}, {"number", finished.number}, {"exit_code", finished.exit_code}});
  return write_whole_file(path_, json.dump(2) + "\n");
}

}  // namespace tetragauge::cli
