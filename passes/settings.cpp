#include "passes/settings.h"

#include <algorithm>
#include <optional>
#include <type_traits>

#include "engine/check.h"

namespace nephele {
namespace {

// The names of each enumeration, in its order.
constexpr const char* kQualityNames[] = {"low", "medium", "high"};
constexpr const char* kMethodNames[] = {"particles", "raymarch"};
constexpr const char* kBackendNames[] = {"auto", "interlock", "attachment", "tiled", "alpha"};
constexpr const char* kBlendModeNames[] = {"volume", "exact"};
constexpr const char* kLightNames[] = {"field", "tables"};

constexpr std::span<const char* const> names_of(Quality) { return kQualityNames; }
constexpr std::span<const char* const> names_of(Method) { return kMethodNames; }
constexpr std::span<const char* const> names_of(Backend) { return kBackendNames; }
constexpr std::span<const char* const> names_of(BlendMode) { return kBlendModeNames; }
constexpr std::span<const char* const> names_of(Light) { return kLightNames; }

template <class Enum>
const char* name_of(Enum value) {
  const std::span<const char* const> names = names_of(value);
  const auto place = static_cast<std::size_t>(value);
  return place < names.size() ? names[place] : "?";
}

template <class Enum>
Enum named(const std::string& name) {
  const std::span<const char* const> names = names_of(Enum{});
  const auto found = std::find(names.begin(), names.end(), name);
  NEPHELE_CHECK(found != names.end(), name);
  return static_cast<Enum>(found - names.begin());
}

template <auto member>
using MemberType = std::remove_cvref_t<decltype(RenderSettings{}.*member)>;

template <auto member>
Value get(const RenderSettings& settings) {
  using Type = MemberType<member>;
  if constexpr (std::is_enum_v<Type>)
    return std::string(name_of(settings.*member));
  else if constexpr (std::is_same_v<Type, bool>)
    return settings.*member;
  else if constexpr (std::is_same_v<Type, double>)
    return settings.*member;
  else
    return std::uint64_t{settings.*member};
}

template <auto member>
void set(RenderSettings& settings, const Value& value) {
  using Type = MemberType<member>;
  if constexpr (std::is_enum_v<Type>)
    settings.*member = named<Type>(std::get<std::string>(value));
  else if constexpr (std::is_same_v<Type, bool>)
    settings.*member = std::get<bool>(value);
  else if constexpr (std::is_same_v<Type, double>)
    settings.*member = std::get<double>(value);
  else
    settings.*member = static_cast<Type>(std::get<std::uint64_t>(value));
}

Value get_size(const RenderSettings& settings) { return ImageSize{settings.width, settings.height}; }

void set_size(RenderSettings& settings, const Value& value) {
  const auto& size = std::get<ImageSize>(value);
  settings.width = size.width_px;
  settings.height = size.height_px;
}

template <auto member>
Setting row(const char* key, const char* option, const char* help, const char* unit, Accepted accepted) {
  return {key, option, help, unit, std::move(accepted), get<member>, set<member>};
}

template <auto member>
Setting toggle(const char* key, const char* option, const char* help) {
  return row<member>(key, option, help, "", Toggle{});
}

template <auto member>
Setting choice(const char* key, const char* option, const char* help) {
  return row<member>(key, option, help, "", OneOfNames(names_of(MemberType<member>{})));
}

using S = RenderSettings;

}  // namespace

std::span<const Setting> all_settings() {
  static const Setting settings[] = {
      {"resolution", "--size", "Size of the image", "pixels", PixelSize{}, get_size, set_size},
      choice<&S::quality>("quality", "--quality", "Size of the cloud grid: cells along a ring, layers"),
      row<&S::scale>("scale", "--scale", "Divisor of the cloud layer's resolution", "", OneOfNumbers{{1, 2, 4}}),
      toggle<&S::full_layer>("full_layer", "--full-layer",
                             "At a scale above 1, keep the cloud layer at the image's size too"),
      toggle<&S::reuse>("reuse", "--reuse",
                        "Do not do again what the frame before left ready, as hosts do; off: every frame's time is "
                        "that of all its work"),
      choice<&S::backend>("backend", "--backend", "How overlapping particles are blended (see nephele devices)"),
      choice<&S::blend>("blend", "--blend",
                        "volume: pairs of particles share their volume; exact: any number (tiled only)"),
      toggle<&S::culling>("culling", "--culling", "Light and sort only particles in view, which changes no pixel"),
      choice<&S::method>("method", "--method",
                         "raymarch: the baseline, rays through the same particles in steps; it has no use for "
                         "backend and blend"),
      row<&S::march_steps>("steps", "--steps",
                           "Steps a marched ray takes across eight particle diameters (16 coarse, 512 fine)", "",
                           WholeNumber{4, 4096}),
      row<&S::ring_size_cells>("ring_size_cells", "--ring-size-cells", "Side of each ring of the cloud grid", "cells",
                               WholeNumber{40, 256, 8, "the quality's own"}),
      row<&S::layer_count>("layers", "--layer-count", "Particles stacked in a cell, the base's included", "",
                           WholeNumber{1, 15, 1, "the quality's own"}),
      row<&S::crown_factor>("crown_factor", "--crown-factor",
                            "Particles of the clouds' crowns, as a multiple of the quality's own", "",
                            RealNumber{0.25, 4}),
      choice<&S::light>("light", "--light",
                        "Where scattered light comes from: one field, or each particle's own tables"),
      toggle<&S::detail>("detail", "--detail",
                         "Particles with the structure of the air; off: smooth ones, by the table of optical depths"),
      row<&S::light_side_cells>("light_side_cells", "--light-side-cells", "Side of the light field's windows", "cells",
                                WholeNumber{32, 256, 16, "the quality's own"}),
      row<&S::light_height_cells>("light_height_cells", "--light-height-cells", "Layers of the light field's windows",
                                  "cells", WholeNumber{8, 128, 1, "the quality's own"}),
      row<&S::light_cell_m>("light_cell_m", "--light-cell-m", "Width of the light field's finest cells", "m",
                            WholeNumber{10, 1000, 1, "the quality's own"}),
      row<&S::light_sweeps>("light_sweeps", "--light-sweeps", "Sweeps of the light field along all its directions", "",
                            WholeNumber{1, 200}),
  };
  return settings;
}

const char* quality_name(Quality quality) { return name_of(quality); }
const char* method_name(Method method) { return name_of(method); }
const char* backend_name(Backend backend) { return name_of(backend); }
const char* blend_mode_name(BlendMode mode) { return name_of(mode); }
const char* light_name(Light light) { return name_of(light); }

Result<void> set_from_text(const Setting& setting, RenderSettings& settings, const std::string& text,
                           const std::string& name) {
  const std::optional<Value> value = read_value(setting.accepted, text);
  if (!value) return not_accepted(name, shown_text(text), setting.accepted);
  setting.set(settings, *value);
  return {};
}

Result<void> check_settings(const RenderSettings& settings) {
  for (const Setting& setting : all_settings())
    if (const Value value = setting.get(settings); !accepts(setting.accepted, value))
      return not_accepted(setting.key, value_text(value), setting.accepted);
  return {};
}

}  // namespace nephele
