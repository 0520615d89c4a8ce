// What the shading of a particle reads besides the particle itself, alike in every way of blending and in the marcher
// (shaders/layer/shading_inputs.glsl).
#pragma once

#include <cstdint>
#include <vector>

#include "engine/frame.h"
#include "lut/gpu_tables.h"
#include "passes/layer/shading_volumes.h"

namespace nephele {

struct ShadingInputs {
  const GpuTables& tables;
  const ShadingVolumes& volumes;
  const Image& light_radiance;  // LightField's; a dummy where light comes from tables
};

// The shaders' specialisation constant that chooses between light from the field and from tables.
inline constexpr std::uint32_t kLightFieldConstant = 20;

// Light and density at places.
inline void append_light_bindings(std::vector<Binding>& bindings, const ShadingInputs& inputs) {
  bindings.emplace_back(17, inputs.tables.multiple_scattering(), Access::sampled);
  bindings.emplace_back(19, inputs.volumes.particle_density(), Access::sampled);
  bindings.emplace_back(20, inputs.light_radiance, Access::sampled);
  bindings.emplace_back(21, inputs.tables.near_beam(), Access::sampled);
}

// The same for particles that are shaded by whole chords. packed: the optical depth table as bytes.
inline void append_chord_bindings(std::vector<Binding>& bindings, const ShadingInputs& inputs, bool packed) {
  append_light_bindings(bindings, inputs);
  if (packed)
    bindings.emplace_back(16, inputs.tables.packed_optical_depth(), Access::words);
  else
    bindings.emplace_back(16, inputs.tables.optical_depth(), Access::sampled);
  bindings.emplace_back(18, inputs.volumes.detail_noise(), Access::sampled, Sampler::linear_repeat);
}

}  // namespace nephele
