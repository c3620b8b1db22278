// SPDX-License-Identifier: GPL-3.0-or-later
// Every command calls this before its work: a wrong output is said before hours of work, not after.
#pragma once

#include <string>
#include <vector>

#include "host/cli/command.hpp"

namespace tetragauge::cli {

// That the files of `outputs` and --json can be written, are different files, and that none of them is one of
// the command's `inputs` (empty names are inputs not given). Else a usage error.
Status check_outputs(const Console& console, const std::vector<std::string>& outputs,
                     const std::vector<std::string>& inputs);

// For options that name an output: an empty name is a usage error.
CLI::Validator not_empty();

}  // namespace tetragauge::cli
