// SPDX-License-Identifier: GPL-3.0-or-later
#include <malloc.h>
#include <tbb/global_control.h>

#include <cstdio>
#include <exception>
#include <limits>
#include <memory>

#include "host/cli/command.hpp"

namespace {

// Large arrays come and go between the stages. Given back to the system each time, their pages would have to
// be cleared again for the next: a tenth of the time for a million points.
void keep_freed_memory() {
  mallopt(M_MMAP_MAX, 0);  // arrays of any size from the heap
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

int fail(const tetragauge::Error& error) {
  std::fprintf(stderr, "tetragauge: %s\n", error.message.c_str());
  return static_cast<int>(error.kind);
}

int succeed(int code) {
  const tetragauge::Status printed = tetragauge::cli::flush_stdout();
  return printed ? code : fail(printed.error());
}

}  // namespace

int main(int argc, char** argv) {
  using namespace tetragauge;
  keep_freed_memory();
  cli::hold_standard_descriptors();
  cli::Console console;
  cli::Run run;
  CLI::App app{"Tetragauge measures a part with a laser and says which of its faces are out of tolerance."};
  app.set_version_flag("--version", cli::kVersion);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 pass or done, 1 out of tolerance, 2 usage, 3 bad input or lost output, 4 machine or "
      "link,\n"
      "5 undecided or not enough measured, 70 internal error.");
  cli::add_measure(app, console, run);
  cli::add_scan(app, console, run);
  cli::add_plan(app, console, run);
  cli::add_simulate(app, console, run);
  cli::add_reconstruct(app, console, run);
  cli::add_faces(app, console, run);
  cli::add_model(app, console, run);
  cli::add_match(app, console, run);
  cli::add_inspect(app, console, run);
  cli::add_history(app, console, run);
  cli::add_teach(app, console, run);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return succeed(app.exit(success));
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    return static_cast<int>(ErrorKind::usage);
  }
  try {
    std::unique_ptr<tbb::global_control> limit;
    if (console.threads > 0) {
      limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<size_t>(console.threads));
    }
    const Result<int> code = run();
    console.end_stage();
    return code ? succeed(*code) : fail(code.error());
  } catch (const std::exception& error) {
    return fail(
        internal_error(std::string("internal error: ") + error.what() + "; please report it with the input"));
  }
}
