// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/teach.hpp"

#include <cmath>
#include <optional>

#include "host/base/whole_file.hpp"
#include "host/link/explain.hpp"
#include "host/session/head_geometry.hpp"
#include "host/session/prepare_machine.hpp"
#include "host/session/show_machine_log.hpp"
#include "host/teach/draw_screen.hpp"
#include "host/teach/raw_terminal.hpp"

namespace tetragauge {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

// Heartbeats want an answer every 100 ms; while something moves the screen follows it.
constexpr milliseconds kIdlePoll{40}, kMovingPoll{5};

// plan.json -> plan.preview.png
fs::path beside(const fs::path& plan, const std::string& ending) {
  return plan.parent_path() / (plan.stem().string() + ending);
}

// The machine's own soft limits, as far as a plan may go.
TeachLimits limits_of(const tg_StageConfig& stage) {
  TeachLimits limits;
  const auto narrow = [](const tg_AxisMotion& motion, double per_step, double& low, double& high) {
    low = std::max(low, motion.min_steps * per_step);
    high = std::min(high, motion.max_steps * per_step);
  };
  if (stage.table_steps_per_turn > 0)
    narrow(stage.table, 360.0 / stage.table_steps_per_turn, limits.table_low_deg, limits.table_high_deg);
  if (stage.slide_steps_per_m > 0)
    narrow(stage.slide, 1000.0 / stage.slide_steps_per_m, limits.slide_low_mm, limits.slide_high_mm);
  return limits;
}

TeachState::Reach reach_of(const HeadConfig& config) {
  return [head = head_geometry(config.galvo, config.stage)](const PlannedView& view) -> Status {
    if (const auto raster = lay_raster(head, view); !raster)
      return usage_error("the window would reach beyond what the mirrors can");
    return Done{};
  };
}

class Teacher {
 public:
  Teacher(const TeachOptions& options, Link* link, const HeadConfig& config, ScanPlan plan)
      : options_(options), link_(link), state_(limits_of(config.stage), reach_of(config), std::move(plan)) {
    facts_.colours = options.colours;
    facts_.plan = options.plan_file.filename().string();
    facts_.machine = link->machine().board;
  }

  Result<Taught> run() {
    bool leaves = false;
    while (!leaves && !RawTerminal::stop_asked()) {
      const bool is_busy = state_.has_machine() && (is_moving_ || !is_there());
      for (const Key& key : terminal_.read(is_busy ? kMovingPoll : kIdlePoll)) {
        leaves = grant(state_.press(key));
        if (leaves) break;
      }
      follow_machine();
      redraw();
    }
    if (!leaves) return rescue();
    return Taught{state_.plan().views.size(), !state_.has_unsaved() && saved_};
  }

 private:
  void redraw() {
    facts_.columns = terminal_.columns();
    facts_.rows = terminal_.rows();
    terminal_.draw(draw_screen(state_, facts_));
  }

  // True: leave.
  bool grant(TeachWish wish) {
    switch (wish) {
      case TeachWish::nothing:
        return false;
      case TeachWish::preview:
        preview();
        return false;
      case TeachWish::save:
        save();
        return false;
      case TeachWish::save_and_leave:
        return save();
      case TeachWish::leave:
        return true;
      case TeachWish::reconnect:
        reconnect();
        return false;
      case TeachWish::suspend:
        terminal_.suspend();
        return false;
    }
    return false;
  }

  ScanOptions scan_options() {
    ScanOptions scan;
    scan.log = [this](const std::string& line) {
      state_.say(line);
      facts_.doing = line == "homing" ? line : facts_.doing;
      redraw();
    };
    return scan;
  }

  void preview() {
    std::atomic<bool> stop{false};
    ScanOptions scan = scan_options();
    scan.stop = &stop;
    scan.on_progress = [&](const ScanProgress& progress) {
      facts_.doing =
          "preview " +
          std::to_string(100 * progress.counts.beams / std::max<size_t>(1, progress.beams_planned)) + " %";
      redraw();
      for (const Key& key : terminal_.read(milliseconds(0)))
        if (key.kind == KeyKind::escape || key.kind == KeyKind::interrupt) stop = true;
      if (RawTerminal::stop_asked()) stop = true;
    };
    facts_.doing = "preview";
    redraw();
    if (const Status rests = come_to_rest(); !rests) {
      facts_.doing.clear();
      lose_machine(rests.error().message);
      return;
    }
    const Result<Preview> taken = take_preview(*link_, state_.view(), preview_size(facts_), scan);
    facts_.doing.clear();
    if (taken) {
      state_.show(*taken);
      sent_table_deg_ = state_.view().table_deg;
      sent_slide_mm_ = state_.view().slide_mm;
      const Status written =
          write_whole_file(beside(options_.plan_file, ".preview.png"), preview_png(*taken));
      if (!written) state_.say(written.error().message);
    } else if (stop) {
      state_.say("preview stopped; the laser is off");
    } else if (taken.error().kind == ErrorKind::bad_input) {
      state_.say(taken.error().message);
    } else {
      lose_machine(taken.error().message);
    }
  }

  // A scan begins with the stage at rest; it then moves by itself to where the keys have sent it.
  Status come_to_rest() {
    if (const Status done = command(*link_, tg_HostMessage_scan_abort_tag); !done) return done;
    for (;;) {
      const Result<tg_Status> status = link_->status();
      if (!status) return status.error();
      if (!status->moving) return Done{};
      const Result<bool> heard = link_->wait_for_frame(kIdlePoll);
      if (!heard) return heard.error();
    }
  }

  bool save() {
    if (state_.plan().views.empty()) {
      state_.say("no view is kept yet, so there is nothing to save; k keeps the view as it stands");
      return false;
    }
    Status written = write_whole_file(options_.plan_file, plan_json(state_.plan()));
    for (size_t k = 0; written && k < state_.pictures().size(); ++k) {
      if (!state_.pictures()[k]) continue;
      written = write_whole_file(beside(options_.plan_file, ".view-" + std::to_string(k + 1) + ".png"),
                                 preview_png(*state_.pictures()[k]));
    }
    if (!written) {
      state_.say(written.error().message);
      return false;
    }
    saved_ = true;
    state_.saved(facts_.plan);
    return true;
  }

  void reconnect() {
    facts_.doing = "connecting";
    state_.say("");
    redraw();
    Status ready = link_ && link_->silent_for() < link_->silence() ? prepare_machine(*link_, scan_options())
                                                                   : Status(machine_error("lost"));
    if (!ready) {
      // The link itself may be the trouble.
      const std::string first = link_ ? ready.error().message : "";
      const Result<Link*> opened = options_.connect();
      link_ = opened ? *opened : nullptr;
      ready = opened ? prepare_machine(*link_, scan_options()) : Status(opened.error());
    }
    Result<HeadConfig> config = ready ? read_head_config(*link_) : Result<HeadConfig>(ready.error());
    facts_.doing.clear();
    if (!config) {
      lose_machine(config.error().message);
      return;
    }
    state_.find_machine(limits_of(config->stage), reach_of(*config));
    sent_table_deg_.reset();
    sent_slide_mm_.reset();
    state_.say("the machine is ready");
  }

  bool is_there() const {
    return sent_table_deg_ == state_.view().table_deg && sent_slide_mm_ == state_.view().slide_mm;
  }

  void follow_machine() {
    if (!link_) return;
    // Frames that came meanwhile: heartbeats are answered, faults noticed.
    const Result<bool> heard = link_->wait_for_frame(milliseconds(1));
    const Result<tg_Status> status = heard ? link_->status() : Result<tg_Status>(heard.error());
    if (!status) {
      if (state_.has_machine()) lose_machine(status.error().message);
      link_ = nullptr;
      return;
    }
    ScanOptions options;
    options.log = [this](const std::string& line) { state_.say(line); };
    show_machine_log(*link_, options);
    facts_.table_deg = status->table_udeg * 1e-6;
    facts_.slide_mm = status->slide_um * 1e-3;
    is_moving_ = status->moving;
    if (!state_.has_machine()) return;
    if (status->state == tg_State_STATE_FAULT || status->state == tg_State_STATE_ESTOP) {
      lose_machine(std::string(explain_fault(status->fault)));
      return;
    }
    facts_.doing = is_moving_ ? "moving" : "";
    if (!is_moving_ && !is_there()) jog();
  }

  // On this screen there is one machine only.
  void lose_machine(const std::string& why) {
    const std::string device = link_ ? link_->device() + ": " : "";
    state_.lose_machine(why.starts_with(device) ? why.substr(device.size()) : why);
  }

  // One axis after the other, always to where the keys have got to by then.
  void jog() {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_move_axis_tag;
    const PlannedView& view = state_.view();
    const bool is_table = sent_table_deg_ != view.table_deg;
    if (is_table) {
      message.body.move_axis = {tg_AxisName_AXIS_TABLE,
                                static_cast<int32_t>(std::lround(view.table_deg * 1e6))};
    } else {
      message.body.move_axis = {tg_AxisName_AXIS_SLIDE,
                                static_cast<int32_t>(std::lround(view.slide_mm * 1e3))};
    }
    const auto reply = link_->request(message);
    if (!reply) {
      lose_machine(reply.error().message);
      return;
    }
    (is_table ? sent_table_deg_ : sent_slide_mm_) = is_table ? view.table_deg : view.slide_mm;
    is_moving_ = true;
  }

  // Nobody can be asked any more.
  Error rescue() {
    const std::string stopped = "stopped while teaching; the laser is off";
    if (!state_.has_unsaved() || state_.plan().views.empty()) return machine_error(stopped);
    const fs::path path = beside(options_.plan_file, ".rescue.json");
    const Status written = write_whole_file(path, plan_json(state_.plan()));
    if (!written) return machine_error(stopped + ", and the plan is lost: " + written.error().message);
    return machine_error(stopped + "; the plan so far is in " + path.string() + ", rename it to " +
                         options_.plan_file.string() + " to go on with it");
  }

  const TeachOptions& options_;
  Link* link_;  // nullptr: lost
  TeachState state_;
  ScreenFacts facts_;
  RawTerminal terminal_;
  // Where the axes were last sent; nothing: they may stand anywhere.
  std::optional<double> sent_table_deg_, sent_slide_mm_;
  bool is_moving_ = false, saved_ = false;
};

}  // namespace

Result<Taught> teach(const TeachOptions& options) {
  if (const Status done = RawTerminal::check(); !done) return done.error();
  ScanPlan plan;
  std::error_code ignored;
  if (fs::exists(options.plan_file, ignored)) {
    Result<ScanPlan> read = read_plan(options.plan_file);
    if (!read) return read.error();
    plan = std::move(*read);
  }
  const Result<Link*> link = options.connect();
  if (!link) return link.error();
  ScanOptions scan;
  scan.log = options.log;
  if (const Status done = prepare_machine(**link, scan); !done) return done.error();
  const Result<HeadConfig> config = read_head_config(**link);
  if (!config) return config.error();
  return Teacher(options, *link, *config, std::move(plan)).run();
}

}  // namespace tetragauge
