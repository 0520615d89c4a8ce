// What the shading of a particle reads besides the particle itself, alike in every way of blending and in the marcher
// (shaders/layer/shading_inputs.glsl).
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "engine/frame.h"
#include "engine/kernel.h"
#include "lut/gpu_tables.h"
#include "passes/layer/shading_volumes.h"

namespace nephele {

struct ShadingInputs {
  const GpuTables& tables;
  const ShadingVolumes& volumes;
  const Image& light_radiance;  // LightField's; a dummy where light comes from tables
};

// What shaders are compiled for; a CPU pays for code that no particle needs.
struct ShadingVariant {
  bool light_field = true;       // light from the field, not from tables
  bool smooth_particles = true;  // there may be reference particles without structure
  bool soft_particles = true;    // there may be soft ones

  std::array<SpecConstant, 3> constants() const {
    return {SpecConstant{20, light_field}, SpecConstant{21, smooth_particles}, SpecConstant{22, soft_particles}};
  }
  // After those of a shader's own.
  std::vector<SpecConstant> after(std::initializer_list<SpecConstant> own) const {
    std::vector<SpecConstant> all(own);
    for (const SpecConstant& constant : constants()) all.push_back(constant);
    return all;
  }
};

// Light and density at places.
inline void append_light_bindings(std::vector<Binding>& bindings, const ShadingInputs& inputs) {
  bindings.emplace_back(17, inputs.tables.multiple_scattering(), Access::sampled);
  bindings.emplace_back(18, inputs.volumes.structure_tile(), Access::sampled, Sampler::linear_repeat);
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
}

}  // namespace nephele
