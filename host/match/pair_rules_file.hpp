// SPDX-License-Identifier: GPL-3.0-or-later
// {"fix": [[model, measured], ...], "forbid": [[model, measured], ...]}: ids as in the two face lists.
#pragma once

#include <filesystem>

#include "host/match/match.hpp"

namespace tetragauge {

Result<PairRules> read_pair_rules(const std::filesystem::path& path);

}  // namespace tetragauge
