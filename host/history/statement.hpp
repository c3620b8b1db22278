// SPDX-License-Identifier: GPL-3.0-or-later
// A prepared statement: values are bound, never pasted into the text.
//
//   Statement insert(database, "INSERT INTO t VALUES (?, ?)");
//   insert.bind(1, name).bind(2, number);
//   insert.run()                                  // SQLITE_DONE, SQLITE_ROW or what went wrong
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <optional>
#include <string>

namespace tetragauge {

class Statement {
 public:
  // A statement that cannot be prepared reports that from run().
  Statement(sqlite3* database, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // Parameters from 1.
  Statement& bind(int parameter, const std::string& text);
  Statement& bind(int parameter, int64_t number);
  Statement& bind(int parameter, double number);
  Statement& bind(int parameter, std::optional<double> number);  // NULL without one
  // For texts of which there may be none: NULL when empty.
  Statement& bind_or_null(int parameter, const std::string& text);

  // The next row, or the end. After the end the statement can be bound and run again.
  int run();

  // Columns from 0 of the row that run() came to.
  std::string text(int column) const;  // "" for NULL
  int64_t integer(int column) const;
  double real(int column) const;
  std::optional<double> optional_real(int column) const;

 private:
  void keep(int code);

  sqlite3_stmt* statement_ = nullptr;
  int failed_ = SQLITE_OK;  // preparing or binding
};

}  // namespace tetragauge
