// SPDX-License-Identifier: GPL-3.0-or-later
// A world that deviates from the nominal one, from a JSON file (keys: sim/README.md).
#pragma once

#include <filesystem>

#include "host/base/result.hpp"
#include "sim/world.hpp"

namespace tetragauge::sim {

// Starts from `setup` and applies what the file says. Unknown keys are errors that name the nearest known
// one.
Result<WorldSetup> read_world(const std::filesystem::path& path, WorldSetup setup = {});

}  // namespace tetragauge::sim
