#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The final image: sky, sun and ground; the cloud layer, brought to the image's resolution, over them through the air
// between; exposure and tone map. A workgroup has a tile of one kind (composite_tiles.glsl), and the kernel of a kind
// holds what such tiles need and nothing else: a CPU driver executes every branch, so every pixel pays for all code of
// its kernel.
#include "shared/atmosphere_tables.h"
#include "shared/blend.h"
#include "shared/ground.h"
#include "shared/haze_shadow_volume.h"
#include "shared/tonemap.h"
#include "shared/types.h"
#include "shared/water.h"
#include "sky/composite_tiles.glsl"
#include "kit/cloud_shadow_lookup.glsl"

layout(constant_id = 0) const uint kKind = kMixedKind;  // of tiles that this kernel is for
// What the frame has. The code for what it lacks is gone once the constants are known, and a dummy image of one texel,
// which nothing reads or writes, is bound in its place.
layout(constant_id = 1) const bool kAir = true;
layout(constant_id = 2) const bool kClouds = true;     // a cloud layer
layout(constant_id = 3) const bool kUpscale = true;    // the layer has a lower resolution than the image
layout(constant_id = 4) const bool kKeepLayer = true;  // the layer is stored once it has the image's resolution
layout(constant_id = 5) const bool kShadow = true;     // of the clouds on ground and haze
const bool kMixed = kKind == kMixedKind;
const bool kSky = kKind < 2u;
const bool kCloudy = ((0x1Au >> kKind) & 1u) != 0u;  // the odd kinds and the mixed one

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D hdr;
layout(set = 0, binding = 2, rgba8) uniform writeonly image2D display;
layout(set = 0, binding = 3) uniform sampler2D transmittance;  // of the air, as are those up to 7: kAir
layout(set = 0, binding = 4) uniform sampler2D sky_irradiance;
layout(set = 0, binding = 5) uniform sampler2D sky_smooth;
layout(set = 0, binding = 6) uniform sampler2D sky_aerosol;
layout(set = 0, binding = 7) uniform sampler2D view_transmittance;
layout(set = 0, binding = 8) uniform sampler2D layer_color;    // kClouds: premultiplied radiance, transmittance
layout(set = 0, binding = 9) uniform sampler2D layer_depth;    // kClouds: metres to the first matter, +inf without
layout(set = 0, binding = 10) uniform sampler3D aerial_light;  // kAir
layout(set = 0, binding = 11) uniform sampler3D aerial_transmittance;  // kAir
layout(set = 0, binding = 12) uniform sampler2D cloud_shadow_map;      // kShadow: see cloud_shadow_lookup.glsl
layout(set = 0, binding = 13) uniform sampler3D haze_shadow;           // kShadow and kAir
layout(set = 0, binding = 14) uniform sampler2D host_distance;
layout(set = 0, binding = 15) uniform sampler2D host_radiance;
layout(set = 0, binding = 16, rgba32f) uniform writeonly image2D full_color;  // kKeepLayer: layer_color upscaled
layout(set = 0, binding = 17, r32f) uniform writeonly image2D full_depth;     // kKeepLayer
layout(set = 0, binding = 18) uniform sampler2D layer_scene;                  // kUpscale: metres to what stands behind
// The camera's place in the world's grid (FrameConstants has it in the clouds', which drift).
layout(push_constant, scalar) uniform Push {
  ivec2 ground_origin_index;
  vec2 camera_ground_m;
  CompositeGrid grid;
};

#include "kit/scene_distance.glsl"
#include "sky/cloud_upscale.glsl"

// The sun's disc, per unit of its irradiance, before the air. Its edge is as soft as a pixel is wide, and a disc
// smaller than a pixel is drawn as large as one: both keep its power.
vec3 sun_disc(vec3 direction, float pixel_rad) {
  float radius = max(frame.sun_angular_radius_rad, 0.6 * pixel_rad);
  float x = length(direction - frame.sun_direction) / radius;
  float edge = pixel_rad / radius;
  if (x >= 1.0 + 0.5 * edge) return vec3(0.0);
  float cover = (1.0 - smoothstep(1.0 - 0.5 * edge, 1.0 + 0.5 * edge, x)) / (1.0 + 0.05 * edge * edge);
  return cover * limb_darkening(min(x, 1.0)) / (kPi * radius * radius);
}

// Light that clouds keep from the air on the way to a distance.
vec3 haze_shadow_at(vec2 image_unit, float distance_m) {
  if (!kShadow) return vec3(0.0);
  if (!kAir) return vec3(0.0);
  return haze_shadow_lookup(haze_shadow, image_unit, distance_m, frame.view_distance_m);
}

// Diffuse irradiance under a cloud per unit of what it keeps from the ground: its transmittance in the two-stream
// approximation, 1 / (1 + 0.75 (1 - g) tau), for tau = 40 and g = 0.85. Without it shadows are as blue as the sky.
const float kCloudDiffuseTransmittance = 0.18;

// What a ray at or above the horizon brings, per unit of the sun's irradiance. disc_share: what shows of the sun's
// disc.
vec3 sky_radiance(vec3 direction, float altitude_m, float horizon_mu, float pixel_rad, vec2 image_unit,
                  float disc_share) {
  if (!kAir) return vec3(0.0);
  vec3 radiance =
      max(vec3(0.0), sky_view_lookup(sky_smooth, sky_aerosol, direction, frame.sun_direction, horizon_mu, false) -
                         haze_shadow_at(image_unit, 1.0e30));
  vec3 disc = kMixed ? sun_disc(direction, pixel_rad) : vec3(0.0);
  if (kMixed && disc.g > 0.0) radiance += disc_share * disc * sun_transmittance(transmittance, altitude_m, direction.z);
  return radiance;
}

// Radiance of water at p_m, seen along a direction, per unit of the sun's irradiance. sun, sky: irradiance of the
// ground.
vec3 water_radiance(vec3 p_m, vec3 direction, float altitude_m, vec3 sun, vec3 sky) {
  vec3 up = normalize(p_m + vec3(0.0, 0.0, kPlanetRadiusM + altitude_m));
  return water_reflection(-dot(up, direction), dot(up, frame.sun_direction), -dot(direction, frame.sun_direction), sun,
                          sky);
}

// What a ray at or below the horizon brings, per unit of the sun's irradiance.
vec3 ground_radiance(vec3 direction, float altitude_m, float horizon_mu, float pixel_rad, vec2 image_unit) {
  float mu = min(direction.z, horizon_mu);
  float distance_m = ground_distance(altitude_m, mu);
  vec3 p_m = direction * distance_m;
  float sunlit = 1.0;
  if (kShadow)
    sunlit = cloud_shadow(cloud_shadow_map, frame.light_from_render, light_uv_scale(frame.view_distance_m), p_m);
  float sun_mu =
      cosine_along_ray(altitude_m, mu, distance_m, frame.sun_direction.z, dot(direction, frame.sun_direction));
  // The pixel on the ground, finite at the horizon, where it ends.
  float short_m = distance_m * pixel_rad;
  float step_m = 2.0 * (distance_m - ground_distance(altitude_m, mu - 0.5 * pixel_rad));
  float long_m = sqrt(short_m * short_m + step_m * step_m);
  vec2 along = normalize(direction.xy + vec2(1.0e-7, 0.0));  // straight down any will do
  vec2 ground_m = grid_from_render(p_m, vec3(camera_ground_m, altitude_m)).xy;
  GroundCover cover = ground_cover(ground_m, ground_origin_index, along, long_m, short_m);
  vec3 albedo = clamp(frame.ground_albedo * cover.albedo_factor, 0.0, 1.0);
  vec3 beam = vec3(max(0.0, sun_mu));  // the sun's irradiance without clouds
  vec3 sky = vec3(0.0);
  if (kAir) {
    beam *= sun_transmittance(transmittance, 0.0, sun_mu);
    sky = sky_irradiance_from_above(sky_irradiance, 0.0, sun_mu);
  } else {
    beam *= sun_visibility(0.0, sun_mu);
  }
  float direct = kAir ? mix(kCloudDiffuseTransmittance, 1.0, sunlit) : sunlit;
  vec3 radiance = albedo / kPi * (beam * direct + sky);
  // In a loop, which ends where no pixel has water: on a CPU a branch costs as much not taken.
  for (float water = cover.water; water > 0.0; water = 0.0)
    radiance = mix(radiance, water_radiance(p_m, direction, altitude_m, beam * sunlit, sky), water);
  if (!kAir) return radiance;
  return radiance * view_transmittance_lookup(view_transmittance, mu, horizon_mu, true) +
         max(vec3(0.0), sky_view_lookup(sky_smooth, sky_aerosol, direction, frame.sun_direction, horizon_mu, true) -
                            haze_shadow_at(image_unit, distance_m));
}

// Light of the sun scattered in the lens, in the display image alone: 0.4 % of it in a halo of half a degree or so.
vec3 sun_glare(vec3 direction) {
  const float kShare = 0.004;
  const float kWidthRad = 0.012;
  vec3 apart = direction - frame.sun_direction;
  float angle2 = dot(apart, apart);
  float edge = max(1.0 - angle2 / 0.1, 0.0);  // an end for it at 18 degrees
  float fall = inversesqrt(1.0 + angle2 / (kWidthRad * kWidthRad));
  return sun_at_lens * (kShare / (2.0 * kPi * kWidthRad * kWidthRad) * fall * fall * fall * edge * edge);
}

// Radiance through the air in front of it.
vec3 through_air(vec3 radiance, float opacity, vec3 direction, float altitude_m, vec2 image_unit, float distance_m) {
  if (!kAir) return radiance;
  AerialSample air =
      aerial_lookup(aerial_light, aerial_transmittance, direction, frame.sun_direction, altitude_m, distance_m);
  vec3 haze = max(vec3(0.0), air.light - haze_shadow_at(image_unit, distance_m)) * frame.sun_irradiance;
  return radiance * air.transmittance + haze * opacity;
}

// Sky, sun and ground where the host has drawn nothing.
vec3 background_radiance(vec3 direction, float altitude_m, float pixel_rad, vec2 image_unit, float disc_share) {
  const float horizon_mu = horizon_cosine(altitude_m);
  if (!kMixed && kSky)
    return sky_radiance(direction, altitude_m, horizon_mu, pixel_rad, image_unit, disc_share) * frame.sun_irradiance;
  if (!kMixed) return ground_radiance(direction, altitude_m, horizon_mu, pixel_rad, image_unit) * frame.sun_irradiance;
  // Share of the pixel above the horizon, so that the horizon has no steps.
  float above = clamp(0.5 + (direction.z - horizon_mu) / pixel_rad, 0.0, 1.0);
  vec3 sky_direction = direction;
  if (frame.ground_enabled == 0u && above < 1.0) {  // without a ground the horizon mirrors the sky
    above = 1.0;
    if (direction.z < horizon_mu) {
      float mu = elevation_from_unit(unit_from_elevation(direction.z, horizon_mu, true), horizon_mu, false);
      float across = sqrt((1.0 - mu * mu) / max(1e-12, 1.0 - direction.z * direction.z));
      sky_direction = vec3(direction.xy * across, mu);
    }
  }
  vec3 background = vec3(0.0);
  if (above > 0.0)
    background += above * sky_radiance(sky_direction, altitude_m, horizon_mu, pixel_rad, image_unit, disc_share);
  if (above < 1.0)
    background += (1.0 - above) * ground_radiance(direction, altitude_m, horizon_mu, pixel_rad, image_unit);
  return background * frame.sun_irradiance;
}

// The cloud layer at a pixel of the image, with the metres to its first matter, +inf without.
vec4 cloud_at(ivec2 pixel, out float cloud_m) {
  if (!kUpscale) {
    cloud_m = texelFetch(layer_depth, pixel, 0).r;
    return texelFetch(layer_color, pixel, 0);
  }
  vec4 cloud = vec4(0.0, 0.0, 0.0, 1.0);
  cloud_m = uintBitsToFloat(0x7f800000u);
  if (kCloudy) cloud = upscaled(vec2(pixel) + 0.5, kMixed, cloud_m);
  if (kKeepLayer) {
    imageStore(full_color, pixel, cloud);
    imageStore(full_depth, pixel, vec4(cloud_m));
  }
  return cloud;
}

void main() {
  uvec2 tile;
  if (!find_composite_tile(grid, kKind, tile)) return;
  const uvec2 pixel = tile * kCompositeTilePx + gl_LocalInvocationID.xy;
  if (any(greaterThanEqual(pixel, frame.image_size_px))) return;
  vec3 direction = pixel_direction(vec2(pixel) + 0.5, frame.image_size_px);
  float pixel_rad = length(pixel_direction(vec2(pixel) + vec2(0.5, 1.5), frame.image_size_px) - direction);
  float altitude_m = max(0.0, frame.camera_grid_m.z);
  vec2 image_unit = (vec2(pixel) + 0.5) / vec2(frame.image_size_px);

  vec4 cloud = vec4(0.0, 0.0, 0.0, 1.0);
  float cloud_m = uintBitsToFloat(0x7f800000u), disc_share = 1.0;
  if (kClouds) {
    cloud = cloud_at(ivec2(pixel), cloud_m);
    // Where blending ended at opaque matter, what transmittance is left is arbitrary, and the disc, 1e5 times as bright
    // as the sky, would show it.
    disc_share = smoothstep(kOpaqueTransmittance, 10.0 * kOpaqueTransmittance, cloud.a);
  }
  const float host_m = kMixed ? host_distance_m(ivec2(pixel)) : kNoSceneM;
  vec3 radiance = host_m < kNoSceneM ? through_air(texelFetch(host_radiance, ivec2(pixel), 0).rgb, 1.0, direction,
                                                   altitude_m, image_unit, host_m)
                                     : background_radiance(direction, altitude_m, pixel_rad, image_unit, disc_share);
  if (kCloudy && !isinf(cloud_m))  // without clouds cloud_m is +inf
    radiance = radiance * cloud.a + through_air(cloud.rgb, 1.0 - cloud.a, direction, altitude_m, image_unit, cloud_m);
  imageStore(hdr, ivec2(pixel), vec4(radiance, 1.0));
  if (kAir) radiance += sun_glare(direction);
  imageStore(display, ivec2(pixel), vec4(display_color(radiance, frame.exposure, pixel), 1.0));
}
