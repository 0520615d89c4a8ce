// The program's subcommands. Each add_* declares its options on the app and says what to run: the error it
// returns is the user's (exit status 2), printed as one line.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "engine/result.h"

namespace nephele::tools {

struct Command {
  CLI::App* app;
  std::function<Result<void>()> run;
};

Command add_render_command(CLI::App& program);
Command add_bake_command(CLI::App& program);
Command add_probe_command(CLI::App& program);
Command add_reference_command(CLI::App& program);
Command add_compare_command(CLI::App& program);
Command add_sweep_command(CLI::App& program);
// With NEPHELE_VIEWER.
Command add_fly_command(CLI::App& program);
Command add_import_command(CLI::App& program);
Command add_export_command(CLI::App& program);
Command add_devices_command(CLI::App& program);
Command add_grow_command(CLI::App& program);

}  // namespace nephele::tools
