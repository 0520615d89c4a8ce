// nephele compare: how far an image is from a reference, as JSON on stdout.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
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
  bool layer = false;
  std::string noise;
};

// Null where there is nothing of the kind.
nlohmann::ordered_json json_of(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

Result<void> run_compare(const CompareOptions& options) {
  const Result<ImageF> test = read_exr(options.test);
  if (!test) return test.error();
  const Result<ImageF> reference = read_exr(options.reference);
  if (!reference) return reference.error();
  const Result<ImageErrors> errors =
      compare_images(*test, options.test, *reference, options.reference, CLI::detail::split(options.channels, ','));
  if (!errors) return errors.error();
  // JSON knows no infinity: what is infinite is written as null.
  nlohmann::ordered_json json{{"rmse", errors->rmse},       {"relmse", errors->relmse},   {"bias", errors->bias},
                              {"max_abs", errors->max_abs}, {"p99_abs", errors->p99_abs}, {"psnr_db", errors->psnr_db},
                              {"pixels", errors->pixels}};
  if (options.layer || !options.noise.empty()) {
    std::optional<ImageF> noise;
    if (!options.noise.empty()) {
      Result<ImageF> image = read_exr(options.noise);
      if (!image) return image.error();
      noise = std::move(*image);
    }
    const Result<LayerErrors> layer =
        compare_layers(*test, options.test, *reference, options.reference, noise ? &*noise : nullptr, options.noise);
    if (!layer) return layer.error();
    json["thin_bias"] = json_of(layer->thin_bias);
    json["thick_bias"] = json_of(layer->thick_bias);
    json["tile_error"] = json_of(layer->tile_error);
    json["tile_error_p95"] = json_of(layer->tile_error_p95);
    json["noise_relmse"] = json_of(layer->noise_relmse);
  }
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
  app->add_flag("--layer", options->layer,
                "Errors by opacity too, of two cloud layers (render --layers): thin_bias where the reference's opacity "
                "is .3 to .97, thick_bias above .995; tile_error and tile_error_p95, mean and 95th percentile of "
                "|test / reference - 1| over tiles of 4x4 pixels of opacity above .97");
  app->add_option("--noise", options->noise,
                  "The reference's whole picture with its standard error (reference --out): noise_relmse, what of "
                  "relmse the reference's own noise makes; takes --layer along")
      ->type_name("PICTURE.exr");
  return {app, [options] { return run_compare(*options); }};
}

}  // namespace nephele::tools
