// What a frame is rendered with, and the table of settings: the command line, sweeps, statistics, --help and the check
// of a host's settings are loops over it. A new setting is a member of RenderSettings, a row of the table in
// settings.cpp, and its use.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/accepted.h"
#include "engine/result.h"

namespace nephele {

// [Yusov14] Table 1: cells along a ring's side, layers (here: above the base particle).
enum class Quality : std::uint8_t { low, medium, high };

// Particles shaded whole and blended, or rays marched through the same particles' density: the baseline.
enum class Method : std::uint8_t { particles, raymarch };

// How overlapping particles are blended; automatic: the device's best (cloud_layer.h).
enum class Backend : std::uint8_t { automatic, interlock, attachment, tiled, alpha };

enum class BlendMode : std::uint8_t {
  volume,  // [Yusov14] Eq. 10-17: exact for two, the third meets the mean of the two
  exact,   // the emission-absorption integral of any number
};

// Where the light that clouds scatter comes from.
enum class Light : std::uint8_t {
  field,   // one field of place for all particles (light/light_field.h)
  tables,  // each particle's own tables, as [Yusov14] has it
};

// As options, sweeps and statistics spell them; "?" for a value that the enumeration lacks.
const char* quality_name(Quality quality);
const char* method_name(Method method);
const char* backend_name(Backend backend);
const char* blend_mode_name(BlendMode mode);
const char* light_name(Light light);

// What each value may be is in the table.
struct RenderSettings {
  std::uint32_t width = 1280, height = 720;  // pixels
  Quality quality = Quality::medium;
  std::uint32_t scale = 1;  // the cloud layer has 1 / scale of the resolution
  bool full_layer = true;   // off: at a scale above 1 the layer alone is not kept at full size, which saves its writing
  bool reuse = true;        // off: every frame does all its work again, which changes no pixel
  Backend backend = Backend::automatic;
  BlendMode blend = BlendMode::volume;  // exact needs the tiled backend
  bool culling = true;                  // off: particles out of view are lit and sorted too, which changes no pixel
  Method method = Method::particles;    // raymarch has no use for backend and blend
  std::uint32_t march_steps = 64;       // that a marched ray takes across eight particle diameters
  std::uint32_t ring_size_cells = 0;    // cells along a ring's side; 0: the quality's
  std::uint32_t layer_count = 0;        // particles stacked in a cell, base included; 0: the quality's
  double crown_factor = 1;              // particles of the clouds' crowns, as a multiple of the quality's
  Light light = Light::field;
  bool detail = true;                  // particles have the structure of the air (docs/shape.md); off: they are smooth
  std::uint32_t light_side_cells = 0;  // of the light field's windows; 0: the quality's
  std::uint32_t light_height_cells = 0;  // their layers; 0: the quality's
  std::uint32_t light_cell_m = 0;        // width of the light field's finest cells; 0: the quality's
  std::uint32_t light_sweeps = 12;       // of the light field along all ordinates
};

struct Setting {
  const char* key;     // in sweeps and statistics: "ring_size_cells"
  const char* option;  // on the command line: "--ring-size-cells"
  const char* help;    // one sentence
  const char* unit;    // "" for a setting without
  Accepted accepted;
  Value (*get)(const RenderSettings& settings);
  void (*set)(RenderSettings& settings, const Value& value);  // of the accepted ones
};

// In the order of RenderSettings; every member is reached by one of them.
std::span<const Setting> all_settings();

// The error names the setting as `name`: its key, its option, its place in a file.
Result<void> set_from_text(const Setting& setting, RenderSettings& settings, const std::string& text,
                           const std::string& name);

// The first setting whose value is not accepted is the error. What a device lacks is Renderer::check's to say.
Result<void> check_settings(const RenderSettings& settings);

}  // namespace nephele
