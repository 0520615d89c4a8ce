// The table of settings: complete, consistent, and strict.
#include "passes/settings.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/support/setting_values.h"

using namespace nephele;
using namespace nephele::test;

TEST_CASE("settings: each member of RenderSettings can be reached through the text of a setting") {
  RenderSettings changed;
  for (const Setting& setting : all_settings())
    REQUIRE(set_from_text(setting, changed, changed_text(setting), setting.key));
  // Stops compiling when RenderSettings gets a member, so that it is compared here too.
  const auto& [width, height, quality, scale, full_layer, reuse, backend, blend, culling, method, march_steps,
               ring_size_cells, layer_count, crown_factor, light, detail, light_side_cells, light_height_cells,
               light_cell_m, light_sweeps] = changed;
  const RenderSettings usual;
  CHECK(width != usual.width);
  CHECK(height != usual.height);
  CHECK(quality != usual.quality);
  CHECK(scale != usual.scale);
  CHECK(full_layer != usual.full_layer);
  CHECK(reuse != usual.reuse);
  CHECK(backend != usual.backend);
  CHECK(blend != usual.blend);
  CHECK(culling != usual.culling);
  CHECK(method != usual.method);
  CHECK(march_steps != usual.march_steps);
  CHECK(ring_size_cells != usual.ring_size_cells);
  CHECK(layer_count != usual.layer_count);
  CHECK(crown_factor != usual.crown_factor);
  CHECK(light != usual.light);
  CHECK(detail != usual.detail);
  CHECK(light_side_cells != usual.light_side_cells);
  CHECK(light_height_cells != usual.light_height_cells);
  CHECK(light_cell_m != usual.light_cell_m);
  CHECK(light_sweeps != usual.light_sweeps);
}

TEST_CASE("settings: a setting changes its own value alone") {
  for (const Setting& setting : all_settings()) {
    RenderSettings changed;
    REQUIRE(set_from_text(setting, changed, changed_text(setting), setting.key));
    for (const Setting& other : all_settings()) {
      CAPTURE(setting.key);
      CAPTURE(other.key);
      CHECK((other.get(changed) != other.get(RenderSettings{})) == (&other == &setting));
    }
  }
}

TEST_CASE("settings: every accepted text is read, and comes back") {
  for (const Setting& setting : all_settings())
    for (const std::string& text : accepted_texts(setting.accepted)) {
      CAPTURE(setting.key);
      CAPTURE(text);
      RenderSettings settings;
      REQUIRE(set_from_text(setting, settings, text, setting.key));
      CHECK(value_text(setting.get(settings)) == text);
      CHECK(check_settings(settings));
    }
}

TEST_CASE("settings: a text that is not accepted changes nothing; the line names setting, text and what is accepted") {
  for (const Setting& setting : all_settings())
    for (const std::string& text : refused_texts(setting.accepted)) {
      CAPTURE(setting.key);
      CAPTURE(text);
      RenderSettings settings;
      const Result<void> result = set_from_text(setting, settings, text, setting.option);
      REQUIRE_FALSE(result);
      const std::string& line = result.error().message;
      CHECK(line.starts_with(std::string(setting.option) + " is "));
      CHECK(line.find(text) != std::string::npos);
      CHECK(line.ends_with("; accepted: " + accepted_words(setting.accepted)));
      CHECK(setting.get(settings) == setting.get(RenderSettings{}));
    }
}

TEST_CASE("settings: the words of an error") {
  RenderSettings settings;
  const auto line = [&](const char* option, const char* text) -> std::string {
    for (const Setting& setting : all_settings())
      if (std::string(setting.option) == option) return set_from_text(setting, settings, text, option).error().message;
    return "";
  };
  CHECK(line("--steps", "3") == "--steps is 3; accepted: a whole number from 4 to 4096");
  CHECK(line("--steps", "many") == "--steps is \"many\"; accepted: a whole number from 4 to 4096");
  CHECK(line("--quality", "ultra") == "--quality is \"ultra\"; accepted: low, medium or high");
  CHECK(line("--scale", "3") == "--scale is 3; accepted: 1, 2 or 4");
  CHECK(line("--reuse", "maybe") == "--reuse is \"maybe\"; accepted: on or off, true or false");
  CHECK(line("--ring-size-cells", "100") ==
        "--ring-size-cells is 100; accepted: a multiple of 8 from 40 to 256, or 0 for the quality's own");
  CHECK(line("--size", "9") == "--size is 9; accepted: WIDTHxHEIGHT, each from 1 to 16384, at most 67108864 pixels");
}

TEST_CASE("settings: a host's values are checked by the same table") {
  CHECK(check_settings({}));
  const auto refuse = [](const RenderSettings& settings, const std::string& start) {
    const Result<void> result = check_settings(settings);
    REQUIRE_FALSE(result);
    CHECK_MESSAGE(result.error().message.starts_with(start), result.error().message);
  };
  refuse({.width = 0}, "resolution is 0x720; accepted: WIDTHxHEIGHT");
  refuse({.height = 16385}, "resolution is 1280x16385");
  refuse({.width = 16384, .height = 16384}, "resolution is 16384x16384");
  refuse({.quality = Quality(3)}, "quality is ?; accepted: low, medium or high");
  refuse({.scale = 3}, "scale is 3; accepted: 1, 2 or 4");
  refuse({.backend = Backend(5)}, "backend is ?");
  refuse({.blend = BlendMode(2)}, "blend is ?");
  refuse({.method = Method(2)}, "method is ?");
  refuse({.march_steps = 0}, "steps is 0; accepted: a whole number from 4 to 4096");
  refuse({.march_steps = 4097}, "steps is 4097");
  refuse({.ring_size_cells = 100}, "ring_size_cells is 100; accepted: a multiple of 8 from 40 to 256");
  refuse({.layer_count = 16}, "layers is 16; accepted: a whole number from 1 to 15");
  refuse({.crown_factor = NAN}, "crown_factor is nan; accepted: a number from 0.25 to 4");
}

TEST_CASE("settings: names are unique and spelt alike") {
  std::set<std::string> keys, options;
  for (const Setting& setting : all_settings()) {
    CAPTURE(setting.key);
    CHECK(keys.insert(setting.key).second);
    CHECK(options.insert(setting.option).second);
    CHECK(std::string(setting.option).starts_with("--"));
    CHECK(std::string(setting.option).find('_') == std::string::npos);
    CHECK(std::string(setting.key).find('-') == std::string::npos);
    CHECK_FALSE(std::string(setting.help).empty());
  }
}

TEST_CASE("accepted values: numbers in words have every digit they need") {
  CHECK(number_text(1e9) == "1000000000");
  CHECK(number_text(1000000001) == "1000000001");
  CHECK(number_text(-0.95) == "-0.95");
  CHECK(number_text(0.1 + 0.2) == "0.30000000000000004");
  CHECK(number_text(0) == "0");
  CHECK(number_text(1e-7) == "1e-07");
  CHECK(number_text(1e300) == "1e+300");
  CHECK(accepted_words(RealNumber{-1e9, 1e9}) == "a number from -1000000000 to 1000000000");
  CHECK(accepted_words(RealNumber{0, 1, false}) == "a number, more than 0, less than 1");
}

TEST_CASE("accepted values: ends of a range, signs and other kinds") {
  const RealNumber closed{0, 1}, open{0, 1, false};
  CHECK(read_value(closed, "0"));
  CHECK(read_value(closed, "1"));
  CHECK(read_value(closed, "+0.5"));
  CHECK_FALSE(read_value(closed, "+-0.5"));
  CHECK_FALSE(read_value(closed, "0x1"));
  CHECK_FALSE(read_value(open, "0"));
  CHECK_FALSE(read_value(open, "1"));
  CHECK(read_value(open, "1e-300"));
  CHECK_FALSE(accepts(WholeNumber{0, 1}, Value(true)));
  CHECK_FALSE(accepts(Toggle{}, Value(std::uint64_t{1})));
  CHECK_FALSE(accepts(closed, Value(std::uint64_t{1})));
}

TEST_CASE("accepted values: typed text in an error line is one printable line, not long") {
  CHECK(shown_text("12") == "12");
  CHECK(shown_text("a b") == "\"a b\"");
  CHECK(shown_text("a\nb\x7f") == "\"a?b?\"");
  CHECK(shown_text("") == "\"\"");
  CHECK(shown_text(std::string(1000, '1')).size() < 80);
}
