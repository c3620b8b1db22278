// SPDX-License-Identifier: GPL-3.0-or-later
// A match as a person reads it.
#pragma once

#include <string>

#include "host/match/match_procrustes.hpp"
#include "host/match/pair_changes.hpp"

namespace tetragauge::cli {

std::string match_text(const Match& match);
std::string procrustes_text(const ProcrustesMatch& procrustes);
std::string pair_changes_text(const PairChanges& changes);

}  // namespace tetragauge::cli
