// nephele compare: how far an image is from a reference, as JSON on stdout.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/image_compare.h"
#include "engine/image_io.h"
#include "tools/command.h"

namespace nephele::tools {
namespace {

// As typed.
struct CompareOptions {
  std::string test, reference;
  std::string channels = "R,G,B";
};

Result<void> run_compare(const CompareOptions& options) {
  const Result<ImageF> test = read_exr(options.test);
  if (!test) return test.error();
  const Result<ImageF> reference = read_exr(options.reference);
  if (!reference) return reference.error();
  const Result<ImageErrors> errors =
      compare_images(*test, options.test, *reference, options.reference, CLI::detail::split(options.channels, ','));
  if (!errors) return errors.error();
  // JSON knows no infinity: what is infinite is written as null.
  const nlohmann::ordered_json json{{"rmse", errors->rmse},       {"relmse", errors->relmse},
                                    {"bias", errors->bias},       {"max_abs", errors->max_abs},
                                    {"p99_abs", errors->p99_abs}, {"psnr_db", errors->psnr_db},
                                    {"pixels", errors->pixels}};
  std::puts(json.dump(2).c_str());
  return {};
}

}  // namespace

Command add_compare_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("compare", "Error metrics between two EXR images, as JSON");
  const auto options = std::make_shared<CompareOptions>();
  app->add_option("test", options->test, "The image to judge")->type_name("TEST.exr")->required();
  app->add_option("reference", options->reference, "What it is compared with")->type_name("REFERENCE.exr")->required();
  app->add_option("--channels", options->channels, "Channels to compare; errors are means over all of them")
      ->type_name("A,B,...")
      ->capture_default_str();
  return {app, [options] { return run_compare(*options); }};
}

}  // namespace nephele::tools
