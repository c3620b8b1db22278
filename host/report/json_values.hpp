// SPDX-License-Identifier: GPL-3.0-or-later
// Values for JSON. Numbers: never NaN or infinite (null says that there is none), never -0.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/geometry/vec.hpp"

namespace tetragauge {

inline nlohmann::ordered_json json_number(double x) {
  if (!std::isfinite(x)) return nullptr;
  return x + 0.0;  // -0.0 + 0.0 is 0.0
}

// Text from a file or its name: bytes that are no UTF-8 have no place in JSON and become U+FFFD.
inline nlohmann::ordered_json json_text(const std::string& text) {
  using nlohmann::ordered_json;
  return ordered_json::parse(ordered_json(text).dump(-1, ' ', false, ordered_json::error_handler_t::replace));
}

// A column vector as a list, a matrix as a list of its rows.
template <class Derived>
nlohmann::ordered_json json_matrix(const Eigen::MatrixBase<Derived>& m) {
  auto rows = nlohmann::ordered_json::array();
  for (Eigen::Index r = 0; r < m.rows(); ++r) {
    if (m.cols() == 1) {
      rows.push_back(json_number(m(r, 0)));
      continue;
    }
    auto row = nlohmann::ordered_json::array();
    for (Eigen::Index c = 0; c < m.cols(); ++c) row.push_back(json_number(m(r, c)));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace tetragauge
