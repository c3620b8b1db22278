// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/scan_journal.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace tetragauge {
namespace {

// Kinds of records, in the order they come.
constexpr char kOrder = 'o';    // JSON
constexpr char kMachine = 'm';  // frame: HelloReply, or Config with galvo or stage
constexpr char kViews = 'v';    // frame: ScanLoad; the last chunk makes the plan whole
constexpr char kRun = 'r';      // boot id, plan id, view, ray: u32 each
constexpr char kItem = 's';     // frame: PointBatch, ScanEnd

template <class Message>
std::string frame_of(const Message& message) {
  std::array<uint8_t, kFrameWireBytes> wire;
  const size_t bytes = encode_message({Channel::kStream, 0}, message, wire.data());
  return {reinterpret_cast<const char*>(wire.data()), bytes};
}

template <class Message>
bool message_of(std::string_view frame, Message& message) {
  FrameReader reader;
  for (const char byte : frame) {
    if (reader.push(static_cast<uint8_t>(byte))) return decode_message(reader.frame(), &message);
  }
  return false;
}

}  // namespace

tg_MachineMessage message_of_item(const std::string& frame) {
  tg_MachineMessage message = tg_MachineMessage_init_zero;
  message_of(frame, message);  // true: it was tried when the journal was read
  return message;
}

std::filesystem::path journal_of(const std::filesystem::path& scan) {
  return scan.string() + ".journal";
}

Result<std::unique_ptr<ScanJournal>> ScanJournal::begin(const std::filesystem::path& path,
                                                        const nlohmann::ordered_json& order) {
  auto file = JournalFile::create(path);
  if (!file) return file.error();
  std::unique_ptr<ScanJournal> journal(new ScanJournal(std::move(*file)));
  journal->order_ = order;
  if (const Status kept = journal->file_->append(kOrder, order.dump()); !kept) return kept.error();
  return journal;
}

Result<std::unique_ptr<ScanJournal>> ScanJournal::reopen(const std::filesystem::path& path) {
  auto opened = JournalFile::open(path);
  if (!opened) return opened.error();
  std::unique_ptr<ScanJournal> journal(new ScanJournal(std::move(opened->file)));
  journal->bytes_cut_ = opened->bytes_cut;
  for (size_t i = 0; i < opened->records.size(); ++i) {
    if (const Status read = journal->read(opened->records[i]); !read) {
      return bad_input(path.string() + ": record " + std::to_string(i) + ": " + read.error().message +
                       "; it is of another version of this program, or damaged: move it away and scan anew");
    }
  }
  // A plan of which only a part was written.
  if (journal->plan_ && journal->runs_.empty()) journal->plan_.reset();
  return journal;
}

Status ScanJournal::read(const JournalRecord& record) {
  tg_MachineMessage message = tg_MachineMessage_init_zero;
  switch (record.kind) {
    case kOrder:
      order_ = nlohmann::ordered_json::parse(record.payload, nullptr, /*allow_exceptions=*/false);
      return order_.is_object() ? Status(Done{}) : bad_input("what was asked for cannot be read");
    case kMachine: {
      if (!message_of(record.payload, message)) return bad_input("not a message of the machine");
      if (message.which_body == tg_MachineMessage_hello_reply_tag) {
        plan_.emplace();
        plan_->machine = message.body.hello_reply;
        return Done{};
      }
      if (!plan_ || message.which_body != tg_MachineMessage_config_tag)
        return bad_input("not the machine's configuration");
      const tg_Config& part = message.body.config;
      if (part.which_part == tg_Config_galvo_tag) plan_->galvo = part.part.galvo;
      if (part.which_part == tg_Config_stage_tag) plan_->stage = part.part.stage;
      return Done{};
    }
    case kViews: {
      tg_HostMessage chunk = tg_HostMessage_init_zero;
      if (!plan_ || !message_of(record.payload, chunk) || chunk.which_body != tg_HostMessage_scan_load_tag)
        return bad_input("not a part of the plan");
      const tg_ScanLoad& load = chunk.body.scan_load;
      plan_->views.insert(plan_->views.end(), load.views, load.views + load.views_count);
      return Done{};
    }
    case kRun: {
      std::array<uint32_t, 4> numbers{};
      if (!plan_ || record.payload.size() != sizeof numbers) return bad_input("not the start of a run");
      std::memcpy(numbers.data(), record.payload.data(), sizeof numbers);
      runs_.push_back(
          {.boot_id = numbers[0], .plan_id = numbers[1], .from = {numbers[2], numbers[3]}, .items = {}});
      return Done{};
    }
    case kItem:
      if (runs_.empty() || !message_of(record.payload, message)) return bad_input("not a stream item");
      runs_.back().items.push_back(record.payload);
      ++items_;
      return Done{};
    default:
      return bad_input("of an unknown kind");
  }
}

Status ScanJournal::keep_plan(JournaledPlan plan) {
  tg_MachineMessage message = tg_MachineMessage_init_zero;
  message.which_body = tg_MachineMessage_hello_reply_tag;
  message.body.hello_reply = plan.machine;
  if (const Status kept = file_->append(kMachine, frame_of(message)); !kept) return kept;
  message = tg_MachineMessage_init_zero;
  message.which_body = tg_MachineMessage_config_tag;
  message.body.config.which_part = tg_Config_galvo_tag;
  message.body.config.part.galvo = plan.galvo;
  if (const Status kept = file_->append(kMachine, frame_of(message)); !kept) return kept;
  message.body.config.which_part = tg_Config_stage_tag;
  message.body.config.part.stage = plan.stage;
  if (const Status kept = file_->append(kMachine, frame_of(message)); !kept) return kept;
  for (const tg_HostMessage& chunk : load_chunks(1, plan.views)) {
    if (const Status kept = file_->append(kViews, frame_of(chunk)); !kept) return kept;
  }
  plan_ = std::move(plan);
  return Done{};
}

Status ScanJournal::keep_run(const JournaledRun& run) {
  const std::array<uint32_t, 4> numbers{run.boot_id, run.plan_id, run.from.view, run.from.ray};
  runs_.push_back(run);
  last_view_ = 0;
  file_->sync_soon();
  return file_->append(kRun, {reinterpret_cast<const char*>(numbers.data()), sizeof numbers});
}

Status ScanJournal::keep_item(const tg_MachineMessage& item) {
  const bool next_view =
      item.which_body != tg_MachineMessage_points_tag || item.body.points.view != last_view_;
  if (item.which_body == tg_MachineMessage_points_tag) last_view_ = item.body.points.view;
  if (next_view) file_->sync_soon();
  if (const Status kept = file_->append(kItem, frame_of(item)); !kept) return kept;
  ++items_;
  return Done{};
}

void ScanJournal::remove() {
  std::error_code ignored;
  std::filesystem::remove(file_->path(), ignored);
}

}  // namespace tetragauge
