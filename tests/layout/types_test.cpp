// C++ and the compiled shaders agree on every offset and size of the structures they share.
#include <doctest/doctest.h>

#include <cstddef>
#include <vector>

#include "engine/kernel.h"
#include "nephele_shaders.h"
#include "shared/field_constants.h"
#include "shared/heightfield.h"
#include "shared/light_lattice.h"
#include "shared/listed_particles.h"
#include "shared/set_instances.h"
#include "shared/types.h"

using namespace nephele;
using namespace nephele::shared;

namespace {

struct Expected {
  const char* name;
  std::size_t offset, bytes;
};

Expected member_at(const char* name, std::size_t offset, std::size_t bytes) { return {name, offset, bytes}; }

void check_layout(const ShaderCode& code, const char* struct_name, const std::vector<Expected>& expected) {
  CAPTURE(struct_name);
  const std::vector<ReflectedMember> members = reflect_struct(code, struct_name);
  REQUIRE(members.size() == expected.size());
  for (std::size_t i = 0; i < members.size(); ++i) {
    CAPTURE(expected[i].name);
    CHECK(members[i].name == expected[i].name);
    CHECK(members[i].offset == expected[i].offset);
    CHECK(members[i].bytes == expected[i].bytes);
  }
}

}  // namespace

#define MEMBER(type, member) member_at(#member, offsetof(type, member), sizeof(type::member))

TEST_CASE("FrameConstants") {
  check_layout(shaders::prepare_draw_comp, "FrameConstants",
               {MEMBER(FrameConstants, clip_from_render),
                MEMBER(FrameConstants, render_from_clip),
                MEMBER(FrameConstants, camera_grid_m),
                MEMBER(FrameConstants, sun_direction),
                MEMBER(FrameConstants, sun_angular_radius_rad),
                MEMBER(FrameConstants, sun_irradiance),
                MEMBER(FrameConstants, exposure),
                MEMBER(FrameConstants, ground_albedo),
                MEMBER(FrameConstants, atmosphere_enabled),
                MEMBER(FrameConstants, image_size_px),
                MEMBER(FrameConstants, layer_size_px),
                MEMBER(FrameConstants, scale),
                MEMBER(FrameConstants, ground_enabled),
                MEMBER(FrameConstants, view_distance_m),
                MEMBER(FrameConstants, clouds_top_m),
                MEMBER(FrameConstants, phase_g),
                MEMBER(FrameConstants, phase_function),
                MEMBER(FrameConstants, light_from_render),
                MEMBER(FrameConstants, host_scene),
                MEMBER(FrameConstants, culling_enabled),
                MEMBER(FrameConstants, detail_enabled),
                MEMBER(FrameConstants, light_unit)});
}

TEST_CASE("Particle") {
  check_layout(
      shaders::particles_comp, "Particle",
      {MEMBER(Particle, center_m), MEMBER(Particle, extinction_per_m), MEMBER(Particle, shape), MEMBER(Particle, flags),
       MEMBER(Particle, orientation), MEMBER(Particle, base_m), MEMBER(Particle, top_m), MEMBER(Particle, id),
       MEMBER(Particle, unused), MEMBER(Particle, radiance_per_sr), MEMBER(Particle, unused2)});
}

TEST_CASE("ParticleLight") {
  check_layout(shaders::occlusion_comp, "ParticleLight",
               {MEMBER(ParticleLight, sun_irradiance), MEMBER(ParticleLight, tau_sun),
                MEMBER(ParticleLight, tau_gradient_per_m), MEMBER(ParticleLight, own_depth)});
}

TEST_CASE("DrawParticle") {
  check_layout(
      shaders::cloud_frag_alpha, "DrawParticle",
      {MEMBER(DrawParticle, reference_from_render), MEMBER(DrawParticle, center_m),
       MEMBER(DrawParticle, light_direction), MEMBER(DrawParticle, extinction_per_m),
       MEMBER(DrawParticle, sun_irradiance), MEMBER(DrawParticle, optical_radius),
       MEMBER(DrawParticle, tau_gradient_per_m), MEMBER(DrawParticle, tau_sun), MEMBER(DrawParticle, ambient_radiance),
       MEMBER(DrawParticle, base_m), MEMBER(DrawParticle, radiance_per_sr), MEMBER(DrawParticle, flags),
       MEMBER(DrawParticle, field_place), MEMBER(DrawParticle, own_depth_share), MEMBER(DrawParticle, field_per_m),
       MEMBER(DrawParticle, structure_depth), MEMBER(DrawParticle, soft_detail)});
}

TEST_CASE("LightLattice and what is in it") {
  check_layout(shaders::light_depth_comp, "LightLattice",
               {MEMBER(LightLattice, levels), MEMBER(LightLattice, level_count), MEMBER(LightLattice, side),
                MEMBER(LightLattice, height), MEMBER(LightLattice, lowest_m), MEMBER(LightLattice, layer_m),
                MEMBER(LightLattice, sun_direction), MEMBER(LightLattice, beam_way_m), MEMBER(LightLattice, moment1),
                MEMBER(LightLattice, moment2), MEMBER(LightLattice, forward), MEMBER(LightLattice, scaled_asymmetry)});
  check_layout(shaders::light_depth_comp, "LightLevel",
               {MEMBER(LightLevel, corner_m), MEMBER(LightLevel, cell_m), MEMBER(LightLevel, reach_m),
                MEMBER(LightLevel, extinction_plane), MEMBER(LightLevel, radiance_plane)});
  check_layout(
      shaders::light_lines_comp, "LightPair",
      {MEMBER(LightPair, direction), MEMBER(LightPair, length_m), MEMBER(LightPair, count), MEMBER(LightPair, stride),
       MEMBER(LightPair, slope), MEMBER(LightPair, reversed), MEMBER(LightPair, axis)});
}

TEST_CASE("FrameCounters") {
  check_layout(
      shaders::prepare_draw_comp, "FrameCounters",
      {MEMBER(FrameCounters, particle_demand), MEMBER(FrameCounters, particle_count),
       MEMBER(FrameCounters, visible_demand), MEMBER(FrameCounters, visible_count),
       MEMBER(FrameCounters, tile_pair_demand), MEMBER(FrameCounters, tile_pair_count),
       MEMBER(FrameCounters, pairs_shaded), MEMBER(FrameCounters, particle_groups),
       MEMBER(FrameCounters, visible_groups), MEMBER(FrameCounters, tile_pair_groups), MEMBER(FrameCounters, draw),
       MEMBER(FrameCounters, screen_pair_demand), MEMBER(FrameCounters, screen_pair_count),
       MEMBER(FrameCounters, screen_pair_groups), MEMBER(FrameCounters, rays_cut_short)});
}

TEST_CASE("SourceRecord") {
  check_layout(shaders::prepare_draw_comp, "SourceRecord",
               {MEMBER(SourceRecord, first), MEMBER(SourceRecord, count), MEMBER(SourceRecord, demand),
                MEMBER(SourceRecord, groups), MEMBER(SourceRecord, extinction_per_m)});
}

TEST_CASE("CloudField and what lies around it") {
  check_layout(shaders::particles_comp, "CloudField",
               {MEMBER(CloudField, origin_index), MEMBER(CloudField, camera_cell), MEMBER(CloudField, growth_turns),
                MEMBER(CloudField, seed), MEMBER(CloudField, coverage), MEMBER(CloudField, base_m),
                MEMBER(CloudField, thickness_m), MEMBER(CloudField, extinction_per_m),
                MEMBER(CloudField, view_distance_m), MEMBER(CloudField, first_ring), MEMBER(CloudField, ring_count),
                MEMBER(CloudField, ring_size_cells), MEMBER(CloudField, layer_count), MEMBER(CloudField, inner_cell_m),
                MEMBER(CloudField, crown_per_cell), MEMBER(CloudField, weather)});
  check_layout(shaders::particles_comp, "WeatherPlacement",
               {MEMBER(WeatherPlacement, size), MEMBER(WeatherPlacement, base), MEMBER(WeatherPlacement, offset),
                MEMBER(WeatherPlacement, per_m)});
  check_layout(shaders::particles_comp, "FieldFrame", {MEMBER(FieldFrame, field), MEMBER(FieldFrame, camera_grid_m)});
  check_layout(shaders::particles_comp, "FieldConstants",
               {MEMBER(FieldConstants, frame), MEMBER(FieldConstants, windows), MEMBER(FieldConstants, near_windows),
                MEMBER(FieldConstants, source), MEMBER(FieldConstants, capacity)});
  check_layout(shaders::fit_capacity_comp, "FieldCounters",
               {MEMBER(FieldCounters, kept_distance_bins), MEMBER(FieldCounters, cell_count),
                MEMBER(FieldCounters, cell_particle_count), MEMBER(FieldCounters, found_cell_count),
                MEMBER(FieldCounters, found_cell_groups), MEMBER(FieldCounters, thin_groups)});
}

TEST_CASE("PlacedParticle") {
  check_layout(shaders::listed_particles_comp, "PlacedParticle",
               {MEMBER(PlacedParticle, place), MEMBER(PlacedParticle, shape), MEMBER(PlacedParticle, extinction_per_m),
                MEMBER(PlacedParticle, orientation), MEMBER(PlacedParticle, flags), MEMBER(PlacedParticle, base_m),
                MEMBER(PlacedParticle, top_m), MEMBER(PlacedParticle, radiance_per_sr), MEMBER(PlacedParticle, id)});
}

TEST_CASE("particle sets") {
  check_layout(shaders::set_instances_comp, "SetKind",
               {MEMBER(SetKind, first), MEMBER(SetKind, count), MEMBER(SetKind, from_m), MEMBER(SetKind, levels),
                MEMBER(SetKind, flags), MEMBER(SetKind, share_below), MEMBER(SetKind, radius_m)});
  check_layout(shaders::set_instances_comp, "ListedInstance",
               {MEMBER(ListedInstance, place), MEMBER(ListedInstance, cos_heading), MEMBER(ListedInstance, sin_heading),
                MEMBER(ListedInstance, scale), MEMBER(ListedInstance, kind), MEMBER(ListedInstance, id)});
  check_layout(shaders::set_instances_comp, "SetConstants",
               {MEMBER(SetConstants, camera), MEMBER(SetConstants, weather), MEMBER(SetConstants, origin_index),
                MEMBER(SetConstants, camera_grid_m), MEMBER(SetConstants, first_cell), MEMBER(SetConstants, lattice),
                MEMBER(SetConstants, side), MEMBER(SetConstants, seed), MEMBER(SetConstants, coverage),
                MEMBER(SetConstants, altitude_m), MEMBER(SetConstants, scale), MEMBER(SetConstants, candidates),
                MEMBER(SetConstants, kinds), MEMBER(SetConstants, view_distance_m), MEMBER(SetConstants, source),
                MEMBER(SetConstants, capacity)});
  check_layout(shaders::set_particles_comp, "SetParticleRecord",
               {MEMBER(SetParticleRecord, center_m), MEMBER(SetParticleRecord, shape),
                MEMBER(SetParticleRecord, extinction_per_m), MEMBER(SetParticleRecord, base_m),
                MEMBER(SetParticleRecord, top_m), MEMBER(SetParticleRecord, seed)});
  check_layout(shaders::set_particles_comp, "SetInstanceRecord",
               {MEMBER(SetInstanceRecord, offset_m), MEMBER(SetInstanceRecord, cos_heading),
                MEMBER(SetInstanceRecord, sin_heading), MEMBER(SetInstanceRecord, scale),
                MEMBER(SetInstanceRecord, kind), MEMBER(SetInstanceRecord, id), MEMBER(SetInstanceRecord, altitude_m),
                MEMBER(SetInstanceRecord, first), MEMBER(SetInstanceRecord, flags), MEMBER(SetInstanceRecord, weight)});
}

TEST_CASE("TerrainConstants") {
  check_layout(
      shaders::terrain_distance_comp, "TerrainConstants",
      {MEMBER(TerrainConstants, camera), MEMBER(TerrainConstants, per_m), MEMBER(TerrainConstants, camera_ground_m),
       MEMBER(TerrainConstants, ground_origin_index), MEMBER(TerrainConstants, vertices),
       MEMBER(TerrainConstants, highest_m), MEMBER(TerrainConstants, levels),
       MEMBER(TerrainConstants, camera_altitude_m), MEMBER(TerrainConstants, has_host),
       MEMBER(TerrainConstants, shadow_stride), MEMBER(TerrainConstants, openness_stride)});
}

TEST_CASE("reflection tells bindings and their direction") {
  const Reflection reflection = reflect(shaders::prepare_draw_comp);
  REQUIRE(reflection.bindings.size() == 11);
  CHECK(reflection.bindings[0].type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER);
  CHECK(reflection.bindings[1].type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);
  CHECK((reflection.bindings[2].reads && !reflection.bindings[2].writes));
  CHECK((!reflection.bindings[6].reads && reflection.bindings[6].writes));
  CHECK(reflection.bindings[7].type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
  CHECK(reflection.local_size[0] == 64);
  CHECK(reflection.push_constant_bytes == 4);
}

TEST_CASE("input attachments and storage images are told apart") {
  const auto at = [](const Reflection& reflection, std::uint32_t binding) {
    for (const ReflectedBinding& own : reflection.bindings)
      if (own.binding == binding) return own;
    return ReflectedBinding{};
  };
  const Reflection attachment = reflect(shaders::cloud_frag_attachment);
  CHECK(at(attachment, 7).type == VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT);
  const Reflection interlock = reflect(shaders::cloud_frag_interlock);
  CHECK(at(interlock, 7).type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE);
  CHECK((at(interlock, 7).reads && at(interlock, 7).writes));
}
