// SPDX-License-Identifier: GPL-3.0-or-later
// Fuzzes the small files: lists of faces, tolerances, plans, world files, the words of --faults, and the
// journal of a scan. The first byte chooses: see kReaders.
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "host/geometry/face_list_file.hpp"
#include "host/inspect/tolerances.hpp"
#include "host/session/plan.hpp"
#include "host/session/scan_journal.hpp"
#include "protocol/frame.hpp"
#include "sim/faults.hpp"
#include "sim/read_world.hpp"
#include "tests/fuzz/check_error.hpp"

using namespace tetragauge;
using fuzz::must;

namespace {

void check_faces(std::string_view text, const char* ending) {
  const std::filesystem::path path = fuzz::input_file(text, ending);
  const Result<FaceList> list = read_face_list(path, 25.4);
  if (!list) return fuzz::check_error(list.error(), path.string());
  for (const Face& face : list->faces) {
    must(face.id > 0, "ids are from 1");
    must(std::isfinite(face.d_mm) && std::isfinite(face.area_mm2) && face.area_mm2 >= 0, "sizes are numbers");
    must(face.point_mm.allFinite() && face.axis.allFinite(), "points are numbers");
    if (face.type != SurfaceType::plane) continue;
    must(std::abs(face.normal.norm() - 1) < 1e-9, "normals are of length 1");
  }
}

void hsp(std::string_view text) {
  check_faces(text, ".hsp");
}

void face_list(std::string_view text) {
  check_faces(text, "_faces.json");
}

void tolerances(std::string_view text) {
  FaceList model;
  for (int id = 1; id <= 3; ++id) {
    Face& face = model.faces.emplace_back();
    face.id = face.surface = id;
  }
  const std::filesystem::path path = fuzz::input_file(text, "_tolerances.json");
  const Result<Tolerances> read = read_tolerances(path, model);
  if (!read) return fuzz::check_error(read.error(), path.string());
  for (const int id : read->skip) must(id >= 1 && id <= 3, "faces that are skipped are there");
  for (const Face& face : model.faces) {
    const FaceTolerance tolerance = read->of(face);
    for (const auto& limit : {tolerance.profile_mm, tolerance.offset_mm, tolerance.flatness_mm})
      must(!limit || (*limit > 0 && std::isfinite(*limit)), "limits are above 0");
  }
}

void plan(std::string_view text) {
  const std::filesystem::path path = fuzz::input_file(text, "_plan.json");
  const Result<ScanPlan> read = read_plan(path);
  if (!read) return fuzz::check_error(read.error(), path.string());
  must(!read->views.empty(), "a plan has views");
  for (const PlannedView& view : read->views) {
    must(view.slide_mm >= 0 && view.slide_mm <= 300, "the slide stays on its rail");
    must(view.samples >= 2 && view.samples % 2 == 0 && view.pitch_mm > 0, "views can be measured");
  }
}

void world(std::string_view text) {
  const std::filesystem::path path = fuzz::input_file(text, "_world.json");
  const auto read = sim::read_world(path, {});
  if (!read) fuzz::check_error(read.error(), path.string());
}

void faults(std::string_view text) {
  const Result<sim::Faults> read = sim::parse_faults(std::string(text));
  if (!read) return fuzz::check_error(read.error(), "--faults");
  for (const sim::TimeSpan& cut : read->line_cut)
    must(cut.until_ns > cut.from_ns, "cuts end after they begin");
}

void check_journal(std::string_view bytes) {
  const std::filesystem::path path = fuzz::input_file(bytes, ".journal");
  const auto journal = ScanJournal::reopen(path);
  if (!journal) return fuzz::check_error(journal.error(), path.string());
  for (const JournaledRun& run : (*journal)->runs()) {
    for (const std::string& item : run.items)
      must(message_of_item(item).which_body != 0, "items are messages");
  }
}

template <class Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

// Records with the right CRC, of payloads in right frames where frames belong: kind, length, bytes.
void records(std::string_view script) {
  std::string journal = "TGJRNL1\n";
  while (script.size() >= 2) {
    const char kind = script[0];
    const size_t length = std::min<size_t>(static_cast<uint8_t>(script[1]), script.size() - 2);
    std::string payload(script.substr(2, length));
    script.remove_prefix(2 + length);
    if (kind == 'm' || kind == 'v' || kind == 's') {
      std::array<uint8_t, kFrameWireBytes> wire;
      const size_t size =
          encode_frame({Channel::kStream, 0}, reinterpret_cast<const uint8_t*>(payload.data()),
                       payload.size(), wire.data());
      payload.assign(reinterpret_cast<const char*>(wire.data()), size);
    }
    std::string record;
    put(record, static_cast<uint32_t>(payload.size()));
    record += kind;
    record += payload;
    put(record, crc32c(record.data(), record.size()));
    journal += record;
  }
  check_journal(journal);
}

constexpr std::array kReaders{hsp, face_list, tolerances, plan, world, faults, check_journal, records};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  kReaders[data[0] % kReaders.size()]({reinterpret_cast<const char*>(data) + 1, size - 1});
  return 0;
}
