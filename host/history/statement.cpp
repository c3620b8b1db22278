// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/statement.hpp"

namespace tetragauge {

Statement::Statement(sqlite3* database, const char* sql) {
  failed_ = sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr);
}

Statement::~Statement() {
  sqlite3_finalize(statement_);
}

void Statement::keep(int code) {
  if (failed_ == SQLITE_OK) failed_ = code;
}

Statement& Statement::bind(int parameter, const std::string& text) {
  // The statement keeps a copy: the text may be gone before it runs.
  keep(sqlite3_bind_text64(statement_, parameter, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(int parameter, int64_t number) {
  keep(sqlite3_bind_int64(statement_, parameter, number));
  return *this;
}

Statement& Statement::bind(int parameter, double number) {
  keep(sqlite3_bind_double(statement_, parameter, number));
  return *this;
}

Statement& Statement::bind(int parameter, std::optional<double> number) {
  if (number) return bind(parameter, *number);
  keep(sqlite3_bind_null(statement_, parameter));
  return *this;
}

Statement& Statement::bind_or_null(int parameter, const std::string& text) {
  if (!text.empty()) return bind(parameter, text);
  keep(sqlite3_bind_null(statement_, parameter));
  return *this;
}

int Statement::run() {
  if (failed_ != SQLITE_OK) return failed_;
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW) sqlite3_reset(statement_);
  return code;
}

std::string Statement::text(int column) const {
  const unsigned char* const text = sqlite3_column_text(statement_, column);
  if (!text) return "";
  return {reinterpret_cast<const char*>(text), static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
}

int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

double Statement::real(int column) const {
  return sqlite3_column_double(statement_, column);
}

std::optional<double> Statement::optional_real(int column) const {
  if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nullopt;
  return real(column);
}

}  // namespace tetragauge
