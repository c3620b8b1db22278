// SPDX-License-Identifier: GPL-3.0-or-later
// A scan that was interrupted, however and wherever, is finished by resume_scan as if nothing had been.
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <random>

#include "host/base/whole_file.hpp"
#include "host/scan/scan_file.hpp"
#include "host/session/emulated_session.hpp"
#include "host/session/scan_journal.hpp"

namespace tetragauge {
namespace {

// So few samples that the mirrors are still moving in the last digits: where they came from matters.
ScanPlan small_plan() {
  ScanPlan plan = plan_all_round(4, 8);
  plan.views.resize(4);
  return plan;
}

std::string undisturbed() {
  static const std::string bytes = [] {
    auto session = start_session({.part = box_file()});
    const auto measured = run_scan(*session->link, small_plan());
    return measured ? scan_to_ply(measured->scan) : "";
  }();
  EXPECT_FALSE(bytes.empty());
  return bytes;
}

std::filesystem::path fresh(const std::string& name) {
  const auto path = temporary_folder() / name;
  std::filesystem::remove(path);
  return path;
}

// The journal of a whole scan, not yet removed.
std::string whole_journal() {
  static const std::string content = [] {
    const auto path = fresh("whole.journal");
    auto session = start_session({.part = box_file()});
    auto journal = ScanJournal::begin(path, {{"name", "test"}});
    const auto measured = run_scan(*session->link, small_plan(), {.journal = journal->get()});
    EXPECT_TRUE(measured) << measured.error().message;
    return *read_whole_file(path);
  }();
  return content;
}

Result<MeasuredScan> resume(Link& link, const std::filesystem::path& path) {
  auto journal = ScanJournal::reopen(path);
  if (!journal) return journal.error();
  EXPECT_TRUE((*journal)->plan());
  return resume_scan(link, {.journal = journal->get()});
}

TEST(Resume, WholeJournalNeedsNothingOfTheMachine) {
  const auto path = temporary_file("complete.journal", whole_journal());
  auto session = start_session({.part = box_file()});
  const auto measured = resume(*session->link, path);
  ASSERT_TRUE(measured) << measured.error().message;
  EXPECT_TRUE(scan_to_ply(measured->scan) == undisturbed());
  EXPECT_EQ((*session->link).status()->state, tg_State_STATE_IDLE);  // not even homed
}

// The machine was switched off and on meanwhile, and the journal ends anywhere.
TEST(Resume, TruncatedAnywhereOnAFreshMachine) {
  const std::string whole = whole_journal();
  const auto path = fresh("truncated.journal");
  std::mt19937 random(7);
  int resumed = 0;
  for (int k = 0; k < 8; ++k) {
    const size_t size = random() % whole.size();
    std::ofstream(path, std::ios::binary) << whole.substr(0, size);
    auto journal = ScanJournal::reopen(path);
    if (!journal || !(*journal)->plan()) continue;  // not even the plan is in it
    journal->reset();
    ++resumed;
    auto session = start_session({.part = box_file()});
    const auto measured = resume(*session->link, path);
    ASSERT_TRUE(measured) << size << ": " << measured.error().message;
    EXPECT_TRUE(scan_to_ply(measured->scan) == undisturbed()) << size << " of " << whole.size() << " bytes";
  }
  EXPECT_GE(resumed, 6);
}

// A cable that is pulled after so many bytes: nothing gets through any more, not even an abort.
class PulledCable final : public Transport {
 public:
  PulledCable(std::unique_ptr<Transport> line, size_t bytes) : line_(std::move(line)), left_(bytes) {}
  Result<size_t> read_some(std::span<uint8_t> buffer, std::chrono::milliseconds timeout) override {
    if (left_ == 0) return machine_error(device() + ": unplugged");
    auto count = line_->read_some(buffer.first(std::min<size_t>(buffer.size(), left_)), timeout);
    if (count) left_ -= *count;
    return count;
  }
  Status write_all(std::span<const uint8_t> bytes, std::chrono::milliseconds timeout) override {
    if (left_ == 0) return machine_error(device() + ": unplugged");
    return line_->write_all(bytes, timeout);
  }
  const std::string& device() const override { return line_->device(); }

 private:
  std::unique_ptr<Transport> line_;
  std::atomic<size_t> left_;
};

// The machine outlives its hosts and keeps what they did not fetch. Pulled several times over.
TEST(Resume, MachineThatStillHoldsTheScan) {
  auto session = start_session({.part = box_file(), .one_host = false});
  ASSERT_TRUE(session) << session.error().message;
  session->link.reset();
  const auto path = fresh("held.journal");
  int pulled = 0, held = 0;
  for (const size_t bytes : {6'000u, 5'000u, 7'000u, 4'000u, 10'000'000u}) {
    auto transport = open_transport(session->machine->device());
    ASSERT_TRUE(transport);
    auto link = Link::connect(std::make_unique<PulledCable>(std::move(*transport), bytes));
    ASSERT_TRUE(link) << link.error().message;
    auto journal =
        pulled == 0 ? ScanJournal::begin(path, nlohmann::ordered_json::object()) : ScanJournal::reopen(path);
    ASSERT_TRUE(journal) << journal.error().message;
    ScanOptions options;
    options.journal = journal->get();
    options.log = [&](const std::string& line) {
      if (line.find("still has") != std::string::npos) ++held;
    };
    const auto measured =
        pulled == 0 ? run_scan(**link, small_plan(), options) : resume_scan(**link, options);
    if (measured) {
      EXPECT_TRUE(scan_to_ply(measured->scan) == undisturbed());
      break;
    }
    EXPECT_NE(measured.error().message.find("unplugged"), std::string::npos) << measured.error().message;
    ++pulled;
  }
  EXPECT_EQ(pulled, 4);
  EXPECT_EQ(held, 4);
}

TEST(Resume, AnotherConfigurationIsRefused) {
  const auto path = temporary_file("other.journal", whole_journal().substr(0, whole_journal().size() / 2));
  const size_t items = (*ScanJournal::reopen(path))->items();
  EXPECT_GT(items, 5u);
  auto session = start_session({.part = box_file(), .one_host = false});
  ASSERT_TRUE(session) << session.error().message;
  auto config = session->link->config(tg_ConfigPart_CONFIG_MEASURE);
  ASSERT_TRUE(config);
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_set_config_tag;
  message.body.set_config = *config;
  message.body.set_config.part.measure.gap_mm *= 2;
  ASSERT_TRUE(session->link->request(message));
  session->link.reset();
  auto link = connect_to(*session->machine);
  ASSERT_TRUE(link) << link.error().message;
  const auto measured = resume(**link, path);
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.error().kind, ErrorKind::bad_input);
  EXPECT_NE(measured.error().message.find("configuration"), std::string::npos) << measured.error().message;
  const auto still = ScanJournal::reopen(path);  // nothing of it was thrown away
  ASSERT_TRUE(still) << still.error().message;
  EXPECT_EQ((*still)->items(), items);
}

}  // namespace
}  // namespace tetragauge
