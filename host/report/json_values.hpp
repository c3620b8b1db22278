// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers for JSON: never NaN or infinite (null says that there is none), never -0.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/geometry/vec.hpp"

namespace tetragauge {

inline nlohmann::ordered_json json_number(double x) {
  if (!std::isfinite(x)) return nullptr;
  return x + 0.0;  // -0.0 + 0.0 is 0.0
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
