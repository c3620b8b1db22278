// SPDX-License-Identifier: GPL-3.0-or-later
// What is kept of one part: who measured it with what, and per face what came out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/inspect/face_inspection.hpp"
#include "host/report/report.hpp"

namespace tetragauge {

// One number of one face, and the limits it has to keep to. A size that cannot be negative (form, flatness,
// profile, a position's distance) has no lower limit.
struct Quantity {
  std::string name;  // offset, form, radius, profile, flatness, position A, ...
  std::string unit;  // mm or mrad
  double value = 0, U = 0;
  std::optional<double> lower{}, upper{};
  // False: it rests on a datum or a pose that is not known; it is kept and never averaged.
  bool is_known = true;
};

struct FaceRecord {
  int face = 0;      // model id
  std::string type;  // plane, cylinder, ...
  bool measured = false;
  double coverage = 0;
  Verdict verdict = Verdict::none;
  std::string reason;
  std::vector<Quantity> quantities;  // of a face that was measured
};

struct PartRecord {
  int64_t number = 0;  // running, from 1; given by the file
  std::string part;    // serial number, or the name of the emulated part's model
  std::string model_sha256, model_name, tolerances_sha256, plan_sha256;  // "": none
  std::string
      held_by;  // "best fit", or the datums; deviations of different ones are not comparable. "": unknown
  std::string machine_id, calibration_id, operator_name;
  std::string start_time;  // of real hardware only
  std::optional<uint64_t> seed{};
  std::string software;
  Verdict verdict = Verdict::none;
  std::string reason;             // why there is no measurement: fault, cable, no match; "": there is one
  std::vector<FaceRecord> faces;  // by model id; none without a measurement
};

// Of an inspected part; `plan_sha256` and `software` are the caller's, and `part` where the scan has no
// serial.
PartRecord record_of(const Report& report);

}  // namespace tetragauge
