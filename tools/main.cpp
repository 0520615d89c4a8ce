// nephele: the command-line program. Exit status: 0 done, 1 internal failure, 2 bad input or missing device.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "engine/device.h"
#include "engine/leak_check.h"
#include "tools/checked_options.h"
#include "tools/command.h"

namespace {

constexpr int kDone = 0, kInternalFailure = 1, kBadInput = 2;

int complain(std::string message, int status) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "nephele: %s\n", message.c_str());
  return status;
}

int run(int argc, char** argv) {
  CLI::App program("Large sunlit cumulus skies, rendered with Vulkan.", "nephele");
  program.set_version_flag("--version", "nephele " NEPHELE_VERSION);
  program.require_subcommand(0, 1);
  program.option_defaults()->take_last();  // an option given twice: scripts put defaults before what the user typed
  const std::vector<nephele::tools::Command> commands{
      nephele::tools::add_render_command(program),  nephele::tools::add_bake_command(program),
      nephele::tools::add_probe_command(program),   nephele::tools::add_reference_command(program),
      nephele::tools::add_compare_command(program), nephele::tools::add_sweep_command(program),
#ifdef NEPHELE_VIEWER
      nephele::tools::add_fly_command(program),
#endif
      nephele::tools::add_import_command(program),  nephele::tools::add_export_command(program),
      nephele::tools::add_grow_command(program),    nephele::tools::add_devices_command(program),
  };
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& stop) {
    if (stop.get_exit_code() == 0) return program.exit(stop);  // --help, --version: to stdout
    return complain(std::string(stop.what()) + " (see --help)", kBadInput);
  }
  const auto chosen = std::find_if(commands.begin(), commands.end(), [](const auto& c) { return c.app->parsed(); });
  if (chosen == commands.end()) return complain("no command given (see --help)", kBadInput);
  if (const auto empty = nephele::tools::find_empty_value(*chosen->app)) return complain(empty->message, kBadInput);
  if (const auto result = chosen->run(); !result) return complain(result.error().message, kBadInput);
  if (const auto messages = nephele::Device::validation_messages(); messages > 0)
    return complain(std::to_string(messages) + " Vulkan validation messages", kInternalFailure);
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  // A failed check (engine/check.h) has printed its line and aborts: an internal failure, not a core dump.
  std::signal(SIGABRT, [](int) { std::_Exit(kInternalFailure); });
  try {
    return run(argc, argv);
  } catch (const std::exception& failure) {
    return complain(std::string("internal failure: ") + failure.what(), kInternalFailure);
  }
}
