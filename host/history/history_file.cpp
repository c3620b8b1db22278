// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/history_file.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "host/history/schema.hpp"
#include "host/history/statement.hpp"

namespace tetragauge {
namespace {

namespace fs = std::filesystem;

// What to do about it; the code with or without its extension.
std::string advice(int code) {
  switch (code) {
    case SQLITE_READONLY_ROLLBACK:
    case SQLITE_READONLY_RECOVERY:
      return "a program was interrupted while writing it, and the folder must be writable once to put that "
             "in "
             "order; open it where you may write";
    default:
      break;
  }
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      return "this is no history file (not an SQLite database); name another file, or none that exists";
    case SQLITE_CORRUPT:
      return "the file is damaged; take the last good copy of it (sqlite3 FILE .recover gets out what can be "
             "read)";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another program has been writing to it all the time; end that, then repeat";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_AUTH:
      return "file and folder must be writable (a journal stands beside the file while it is written); name "
             "another folder or change the permissions";
    case SQLITE_FULL:
      return "the disk is full; make room, then repeat. The parts before are kept";
    case SQLITE_IOERR:
      return "the disk or the network share failed; the parts before are kept. Check it, then repeat";
    default:
      return "please report it with the file";
  }
}

Error failure(sqlite3* database, int code, const std::string& name, const std::string& what) {
  const int extended = database ? sqlite3_extended_errcode(database) : code;
  const bool same = (extended & 0xff) == (code & 0xff);
  return bad_input(name + ": cannot " + what + ": " + sqlite3_errstr(code) + "; " +
                   advice(same ? extended : code));
}

int run(sqlite3* database, const char* sql) {
  const int code = Statement(database, sql).run();
  return code == SQLITE_ROW || code == SQLITE_DONE ? SQLITE_OK : code;
}

// A pragma or count that is one number.
int number_of(sqlite3* database, const char* sql, int64_t& number) {
  Statement statement(database, sql);
  const int code = statement.run();
  if (code != SQLITE_ROW) return code == SQLITE_DONE ? SQLITE_CORRUPT : code;
  number = statement.integer(0);
  return SQLITE_OK;
}

constexpr std::array kVerdicts{Verdict::pass,         Verdict::fail,    Verdict::undecided,
                               Verdict::not_measured, Verdict::skipped, Verdict::none};

std::optional<Verdict> verdict_named(const std::string& name) {
  for (const Verdict verdict : kVerdicts)
    if (verdict_name(verdict) == name) return verdict;
  return std::nullopt;
}

std::optional<uint64_t> seed_of(const std::string& text) {
  uint64_t seed = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (text.empty() || code != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return seed;
}

bool is_finite(const PartRecord& record) {
  for (const FaceRecord& face : record.faces) {
    if (!std::isfinite(face.coverage)) return false;
    for (const Quantity& q : face.quantities) {
      if (!std::isfinite(q.value) || !std::isfinite(q.U) || !std::isfinite(q.lower.value_or(0)) ||
          !std::isfinite(q.upper.value_or(0)))
        return false;
    }
  }
  return true;
}

}  // namespace

void HistoryFile::Close::operator()(sqlite3* database) const {
  sqlite3_close(database);
}

Result<HistoryFile> HistoryFile::open(const fs::path& path, int flags, HistoryOptions options) {
  // SQLite takes names like :memory: for something else, and a device for a file.
  std::error_code ignored;
  const fs::path absolute = fs::absolute(path, ignored);
  const fs::file_status status = fs::status(absolute, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status))
    return bad_input(path.string() + ": is no regular file; a history is one");
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(absolute.c_str(), &raw, flags, nullptr);
  HistoryFile file(Database(raw), path.string());
  if (code != SQLITE_OK) return failure(raw, code, file.name_, "open it");
  sqlite3_extended_result_codes(raw, 1);
  sqlite3_busy_timeout(raw, static_cast<int>(options.wait_for_others.count()));
  // A rollback journal, which is the default, and no write-ahead log: that needs shared memory, which a
  // network share has not, and two more files that somebody copying the history forgets. EXTRA also brings
  // the folder's entry of the journal to the disk, so that a cut of power leaves whole parts.
  for (const char* pragma :
       {"PRAGMA foreign_keys = ON", "PRAGMA synchronous = EXTRA", "PRAGMA trusted_schema = OFF"}) {
    if (const int failed = run(raw, pragma); failed != SQLITE_OK)
      return failure(raw, failed, file.name_, "open it");
  }
  return file;
}

Status HistoryFile::check_schema(bool make) {
  sqlite3* const database = database_.get();
  int64_t application = 0, version = 0, tables = 0;
  int code = number_of(database, "SELECT count(*) FROM sqlite_master", tables);
  if (code == SQLITE_OK) code = number_of(database, "PRAGMA application_id", application);
  if (code == SQLITE_OK) code = number_of(database, "PRAGMA user_version", version);
  if (code != SQLITE_OK) return failure(database, code, name_, "read it");
  if (tables == 0 && application == 0 && version == 0) {
    if (!make) return bad_input(name_ + ": there is nothing in it; measure --history fills it");
    for (const char* sql : kSchema) {
      code = run(database, sql);
      if (code != SQLITE_OK) return failure(database, code, name_, "make its tables");
    }
    // A pragma takes no bound values; these are constants.
    const std::string mark = "PRAGMA application_id = " + std::to_string(kApplicationId);
    const std::string number = "PRAGMA user_version = " + std::to_string(kSchemaVersion);
    code = run(database, mark.c_str());
    if (code == SQLITE_OK) code = run(database, number.c_str());
    if (code != SQLITE_OK) return failure(database, code, name_, "make its tables");
    return Done{};
  }
  if (application != kApplicationId)
    return bad_input(name_ + ": is a database of another program; name another file");
  if (version > kSchemaVersion)
    return bad_input(name_ + ": was made by a newer tetragauge (history version " + std::to_string(version) +
                     ", this one knows " + std::to_string(kSchemaVersion) + "); use that one");
  if (version < kSchemaVersion)
    return bad_input(name_ + ": has history version " + std::to_string(version) +
                     ", which no tetragauge has written; take the last good copy of it");
  return Done{};
}

Result<HistoryFile> HistoryFile::open_to_read(const fs::path& path, HistoryOptions options) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    return bad_input(path.string() + ": there is no such file; measure --history makes it");
  // Read-write where that is possible: what an interrupted writer left has to be put in order first.
  Result<HistoryFile> file = open(path, SQLITE_OPEN_READWRITE, options);
  if (!file) return file;
  if (Status checked = file->check_schema(false); !checked) return checked.error();
  return file;
}

Result<HistoryFile> HistoryFile::open_to_add(const fs::path& path, HistoryOptions options) {
  Result<HistoryFile> file = open(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, options);
  if (!file) return file;
  sqlite3* const database = file->database_.get();
  // SQLite opens for reading what it may not write, and even begins to write it.
  if (sqlite3_db_readonly(database, "main") == 1)
    return failure(nullptr, SQLITE_READONLY, file->name_, "write to it");
  // Two programs may both find it empty: looked at again with the lock held.
  if (const int code = run(database, "BEGIN IMMEDIATE"); code != SQLITE_OK)
    return failure(database, code, file->name_, "write to it");
  const Status checked = file->check_schema(true);
  const int code = checked ? run(database, "COMMIT") : SQLITE_OK;
  if (!checked || code != SQLITE_OK) {
    const Error error = checked ? failure(database, code, file->name_, "make its tables") : checked.error();
    (void)run(database, "ROLLBACK");
    return error;
  }
  return file;
}

Status HistoryFile::insert(PartRecord record, int64_t& number) {
  sqlite3* const database = database_.get();
  const auto failed = [&](int code) { return failure(database, code, name_, "add the part"); };
  Statement part(database,
                 "INSERT INTO part (part, model_sha256, model_name, tolerances_sha256, plan_sha256, held_by, "
                 "machine_id, calibration_id, operator, start_time, seed, software, verdict, reason) "
                 "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  part.bind(1, record.part)
      .bind(2, record.model_sha256)
      .bind(3, record.model_name)
      .bind_or_null(4, record.tolerances_sha256)
      .bind_or_null(5, record.plan_sha256)
      .bind(6, record.held_by)
      .bind(7, record.machine_id)
      .bind(8, record.calibration_id)
      .bind_or_null(9, record.operator_name)
      .bind_or_null(10, record.start_time)
      .bind_or_null(11, record.seed ? std::to_string(*record.seed) : "")
      .bind(12, record.software)
      .bind(13, std::string(verdict_name(record.verdict)))
      .bind_or_null(14, record.reason);
  if (const int code = part.run(); code != SQLITE_DONE) return failed(code);
  number = sqlite3_last_insert_rowid(database);

  Statement face(database,
                 "INSERT INTO face (part_number, face, type, measured, coverage, verdict, reason) "
                 "VALUES (?, ?, ?, ?, ?, ?, ?)");
  Statement deviation(database,
                      "INSERT INTO deviation (part_number, face, running, name, unit, value, U, lower_limit, "
                      "upper_limit, is_known) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const FaceRecord& f : record.faces) {
    face.bind(1, number)
        .bind(2, int64_t{f.face})
        .bind(3, f.type)
        .bind(4, int64_t{f.measured})
        .bind(5, f.coverage)
        .bind(6, std::string(verdict_name(f.verdict)))
        .bind_or_null(7, f.reason);
    if (const int code = face.run(); code != SQLITE_DONE) return failed(code);
    for (size_t k = 0; k < f.quantities.size(); ++k) {
      const Quantity& q = f.quantities[k];
      deviation.bind(1, number)
          .bind(2, int64_t{f.face})
          .bind(3, static_cast<int64_t>(k + 1))
          .bind(4, q.name)
          .bind(5, q.unit)
          .bind(6, q.value)
          .bind(7, q.U)
          .bind(8, q.lower)
          .bind(9, q.upper)
          .bind(10, int64_t{q.is_known});
      if (const int code = deviation.run(); code != SQLITE_DONE) return failed(code);
    }
  }
  return Done{};
}

Result<int64_t> HistoryFile::add(const PartRecord& record) {
  if (!is_finite(record))
    return internal_error(name_ + ": a deviation of part " + record.part + " is no number");
  sqlite3* const database = database_.get();
  if (const int code = run(database, "BEGIN IMMEDIATE"); code != SQLITE_OK)
    return failure(database, code, name_, "add the part");
  int64_t number = 0;
  Status inserted = insert(record, number);
  if (inserted) {
    if (const int code = run(database, "COMMIT"); code != SQLITE_OK)
      inserted = failure(database, code, name_, "add the part");
  }
  if (!inserted) {
    // Some failures have rolled back already; then this one has nothing to do.
    (void)run(database, "ROLLBACK");
    return inserted.error();
  }
  return number;
}

Result<std::vector<PartRecord>> HistoryFile::parts() {
  sqlite3* const database = database_.get();
  const auto failed = [&](int code) { return failure(database, code, name_, "read it"); };
  const auto damaged = [&](int64_t number, const std::string& what) {
    return bad_input(name_ + ": part " + std::to_string(number) + " " + what +
                     "; the file was changed by another program, take the last good copy of it");
  };
  // The three queries see one state of the file.
  if (const int code = run(database, "BEGIN"); code != SQLITE_OK) return failed(code);
  struct End {
    sqlite3* database;
    ~End() { (void)run(database, "ROLLBACK"); }
  } end{database};
  std::vector<PartRecord> parts;
  Statement part(database,
                 "SELECT number, part, model_sha256, model_name, tolerances_sha256, plan_sha256, held_by, "
                 "machine_id, calibration_id, operator, start_time, seed, software, verdict, reason "
                 "FROM part ORDER BY number");
  int code = SQLITE_ROW;
  while ((code = part.run()) == SQLITE_ROW) {
    PartRecord record;
    record.number = part.integer(0);
    record.part = part.text(1);
    record.model_sha256 = part.text(2);
    record.model_name = part.text(3);
    record.tolerances_sha256 = part.text(4);
    record.plan_sha256 = part.text(5);
    record.held_by = part.text(6);
    record.machine_id = part.text(7);
    record.calibration_id = part.text(8);
    record.operator_name = part.text(9);
    record.start_time = part.text(10);
    record.seed = seed_of(part.text(11));
    record.software = part.text(12);
    const auto verdict = verdict_named(part.text(13));
    if (!verdict) return damaged(record.number, "has an unknown verdict");
    record.verdict = *verdict;
    record.reason = part.text(14);
    parts.push_back(std::move(record));
  }
  if (code != SQLITE_DONE) return failed(code);

  Statement face(database,
                 "SELECT part_number, face, type, measured, coverage, verdict, reason FROM face "
                 "ORDER BY part_number, face");
  size_t at = 0;
  while ((code = face.run()) == SQLITE_ROW) {
    while (at < parts.size() && parts[at].number < face.integer(0)) ++at;
    const auto verdict = verdict_named(face.text(5));
    if (at == parts.size() || parts[at].number != face.integer(0) || !verdict)
      return damaged(face.integer(0), "has a face that belongs to nothing or has an unknown verdict");
    parts[at].faces.push_back({.face = static_cast<int>(face.integer(1)),
                               .type = face.text(2),
                               .measured = face.integer(3) != 0,
                               .coverage = face.real(4),
                               .verdict = *verdict,
                               .reason = face.text(6),
                               .quantities = {}});
  }
  if (code != SQLITE_DONE) return failed(code);

  Statement deviation(database,
                      "SELECT part_number, face, name, unit, value, U, lower_limit, upper_limit, is_known "
                      "FROM deviation ORDER BY part_number, face, running");
  at = 0;
  size_t at_face = 0;
  while ((code = deviation.run()) == SQLITE_ROW) {
    for (; at < parts.size() && parts[at].number < deviation.integer(0); ++at) at_face = 0;
    const bool is_part = at < parts.size() && parts[at].number == deviation.integer(0);
    while (is_part && at_face < parts[at].faces.size() &&
           parts[at].faces[at_face].face < deviation.integer(1))
      ++at_face;
    const Quantity quantity{.name = deviation.text(2),
                            .unit = deviation.text(3),
                            .value = deviation.real(4),
                            .U = deviation.real(5),
                            .lower = deviation.optional_real(6),
                            .upper = deviation.optional_real(7),
                            .is_known = deviation.integer(8) != 0};
    if (!is_part || at_face == parts[at].faces.size() ||
        parts[at].faces[at_face].face != deviation.integer(1) || !std::isfinite(quantity.value))
      return damaged(deviation.integer(0), "has a deviation that belongs to no face or is no number");
    parts[at].faces[at_face].quantities.push_back(quantity);
  }
  if (code != SQLITE_DONE) return failed(code);
  return parts;
}

}  // namespace tetragauge
