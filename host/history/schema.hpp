// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of a history file (README.md explains them).
#pragma once

#include <cstdint>

namespace tetragauge {

// "TGhi": marks the file as ours (PRAGMA application_id).
inline constexpr int64_t kApplicationId = 0x54476869;
// Of the tables (PRAGMA user_version). A program reads files of its own version.
inline constexpr int64_t kSchemaVersion = 1;

// AUTOINCREMENT: the number of a part that somebody deleted is not given again.
inline constexpr const char* kSchema[] = {
    R"(CREATE TABLE part (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  part TEXT NOT NULL,
  model_sha256 TEXT NOT NULL,
  model_name TEXT NOT NULL,
  tolerances_sha256 TEXT,
  plan_sha256 TEXT,
  held_by TEXT NOT NULL,
  machine_id TEXT NOT NULL,
  calibration_id TEXT NOT NULL,
  operator TEXT,
  start_time TEXT,
  seed TEXT,
  software TEXT NOT NULL,
  verdict TEXT NOT NULL,
  reason TEXT))",
    R"(CREATE TABLE face (
  part_number INTEGER NOT NULL REFERENCES part(number) ON DELETE CASCADE,
  face INTEGER NOT NULL,
  type TEXT NOT NULL,
  measured INTEGER NOT NULL CHECK (measured IN (0, 1)),
  coverage REAL NOT NULL,
  verdict TEXT NOT NULL,
  reason TEXT,
  PRIMARY KEY (part_number, face)) WITHOUT ROWID)",
    // The running number keeps the order in which a face's numbers are listed.
    R"(CREATE TABLE deviation (
  part_number INTEGER NOT NULL,
  face INTEGER NOT NULL,
  running INTEGER NOT NULL,
  name TEXT NOT NULL,
  unit TEXT NOT NULL,
  value REAL NOT NULL,
  U REAL NOT NULL,
  lower_limit REAL,
  upper_limit REAL,
  is_known INTEGER NOT NULL CHECK (is_known IN (0, 1)),
  PRIMARY KEY (part_number, face, running),
  FOREIGN KEY (part_number, face) REFERENCES face(part_number, face) ON DELETE CASCADE) WITHOUT ROWID)",
    "CREATE INDEX part_by_model ON part(model_sha256)"};

}  // namespace tetragauge
