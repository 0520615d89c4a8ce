// The terrain's light: sun past mountains and clouds, sky, and what the land around reflects; on land coloured by
// height and slope, all of it as a pixel's footprint has it in the mean. Where the host's scene is nearer, its radiance
// stays.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/atmosphere_tables.h"
#include "shared/water.h"
#include "sky/terrain_arrays.glsl"
#include "kit/cloud_shadow_lookup.glsl"

layout(constant_id = 0) const bool kAir = true;
layout(constant_id = 1) const bool kShadow = true;  // of clouds

layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
WORDS(4, nodes);
WORDS(5, horizon);
WORDS(6, openness);
layout(set = 0, binding = 7) uniform sampler2D distance_m;
layout(set = 0, binding = 8) uniform sampler2D host_distance;
layout(set = 0, binding = 9) uniform sampler2D host_radiance;
layout(set = 0, binding = 10) uniform sampler2D transmittance;     // kAir
layout(set = 0, binding = 11) uniform sampler2D sky_irradiance;    // kAir
layout(set = 0, binding = 12) uniform sampler2D cloud_shadow_map;  // kShadow
layout(set = 0, binding = 13, rgba32f) writeonly uniform image2D radiance;

#include "kit/camera_rays.glsl"

// Diffuse irradiance under a cloud per unit of what it keeps from the ground, as composite.comp has it.
const float kCloudDiffuseTransmittance = 0.18;
// Of the light on the land around a place, what it sends on: the mean albedo of open country, in sun and in shadow.
const float kLitAround = 0.75;

// Bilinear between the samples of every n-th vertex; the last column and row are the lattice's own.
#define SAMPLED(name, place, stride)                                                                    \
  float name##_at(vec2 place_in) {                                                                      \
    const ivec2 size = terrain_samples(view.vertices, stride);                                          \
    const vec2 p = clamp(place_in / float(stride), vec2(0.0), vec2(size - 1));                          \
    const ivec2 low = min(ivec2(p), size - 2);                                                          \
    const vec2 f = p - vec2(low);                                                                       \
    const uint i = uint(low.y * size.x + low.x);                                                        \
    return mix(mix(float_at(name, i), float_at(name, i + 1u), f.x),                                     \
               mix(float_at(name, i + uint(size.x)), float_at(name, i + uint(size.x) + 1u), f.x), f.y); \
  }
SAMPLED(horizon, place, view.shadow_stride)
SAMPLED(openness, place, view.openness_stride)

// Mean slope east and north (x, y) and mean steepness (z), at a level of the nodes' pyramid.
vec3 node(uint first, ivec2 size, ivec2 at) {
  const ivec2 inside = clamp(at, ivec2(0), size - 1);
  const uvec2 words = two_words_at(nodes, first + uint(inside.y * size.x + inside.x));
  return vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
}

vec3 slopes_at(vec2 place, uint level) {
  uint first = 0u;
  ivec2 size = view.vertices;
  for (uint i = 0u; i < level; ++i) {
    first += uint(size.x * size.y);
    size = (size + 1) >> 1;
  }
  const vec2 p = (place + 0.5) / float(1u << level) - 0.5;
  const vec2 cell = floor(p), f = p - cell;
  const ivec2 at = ivec2(cell);
  return mix(mix(node(first, size, at), node(first, size, at + ivec2(1, 0)), f.x),
             mix(node(first, size, at + ivec2(0, 1)), node(first, size, at + ivec2(1, 1)), f.x), f.y);
}

vec3 slopes_under(vec2 place, float footprint_m) {
  const float level = clamp(log2(max(footprint_m * min(view.per_m.x, view.per_m.y), 1e-3)), 0.0, 7.0);
  const vec3 fine = slopes_at(place, uint(level));
  return mix(fine, slopes_at(place, uint(level) + 1u), fract(level));
}

// A direction of render space, seen from a place in an azimuth at an arc: in the axes that lie level there.
vec3 level_axes(vec3 direction, vec2 azimuth, float arc_m) {
  const float half_tangent = half_arc_tangent(arc_m);
  const float scale = 1.0 / (1.0 + half_tangent * half_tangent);
  const float sine = 2.0 * half_tangent * scale, cosine = (1.0 - half_tangent * half_tangent) * scale;
  const float along = dot(direction.xy, azimuth);
  return vec3(direction.xy + azimuth * (along * (cosine - 1.0) - direction.z * sine),
              along * sine + direction.z * cosine);
}

const float kCrestFacing = 0.3;  // cosine between normal and the way to the eye, below which a crest may be near

vec3 shaded(vec3 direction, float distance, float pixel_rad) {
  const TerrainRay ray = terrain_ray(view, direction);
  const float arc_m = ray_arc_at_distance(ray, distance);
  const vec2 place = ray.start + ray.per_arc_m * arc_m;
  const float altitude_m = max(ray_altitude_at_arc(ray, arc_m), 0.0);
  const vec2 azimuth = ray.per_arc_m / view.per_m;
  const vec3 seen_along = level_axes(direction, azimuth, arc_m), sun = level_axes(frame.sun_direction, azimuth, arc_m);

  // The footprint is longer than a pixel is wide where the surface slants away; its slant is that of the mean surface.
  const float width_m = distance * pixel_rad;
  vec3 slopes = slopes_under(place, 2.0 * width_m);
  vec3 normal = normalize(vec3(-slopes.xy, 1.0));
  // On a crest that mean takes in the far side, which the pixel does not see: slopes and the sun's horizon are those of
  // the near side there.
  const float steep = 1.0 - smoothstep(0.5 * kCrestFacing, kCrestFacing, -dot(normal, seen_along));
  const vec2 near_side = place - normalize(ray.per_arc_m) * (steep * max(float(view.shadow_stride), 1.5));
  const uint crests = steep > 0.0 ? 1u : 0u;
  for (uint i = 0u; i < crests; ++i) {
    slopes = mix(slopes, slopes_under(near_side, 0.0), steep);
    normal = normalize(vec3(-slopes.xy, 1.0));
    normal = normalize(normal - seen_along * max(0.0, 0.02 + dot(normal, seen_along)));
  }
  const float facing = clamp(-dot(normal, seen_along), 0.02, 1.0);
  const float length_m = width_m / facing;

  const vec2 ground_m = view.camera_ground_m + azimuth * arc_m;
  // A loop again: high up nothing is left of the plain's country.
  vec3 country = frame.ground_albedo;
  float water = 0.0;
  const uint lowlands = altitude_m < kCountryTopM ? 1u : 0u;
  for (uint i = 0u; i < lowlands; ++i) {
    const GroundCover cover = ground_cover(ground_m, view.ground_origin_index, azimuth,
                                           sqrt(width_m * width_m + length_m * length_m), width_m);
    country *= cover.albedo_factor;
    water = cover.water * terrain_water_share(altitude_m, slopes.z);
  }
  const vec3 albedo = terrain_albedo(clamp(country, 0.0, 1.0), altitude_m, sqrt(max(slopes.z, 0.0)),
                                     relief_noise(ground_m, view.ground_origin_index, length_m));

  const float sun_tangent = sun.z / max(length(sun.xy), 1e-4);
  const float past_mountains = sun_above_horizon(sun_tangent, horizon_at(near_side), frame.sun_angular_radius_rad);
  float past_clouds = 1.0;
  if (kShadow)
    past_clouds = cloud_shadow(cloud_shadow_map, frame.light_from_render, light_uv_scale(frame.view_distance_m),
                               direction * distance);
  const float tilted = max(dot(normal, sun), 0.0), level = max(sun.z, 0.0);
  const float direct = tilted * past_mountains * past_clouds;
  if (!kAir) return albedo / kPi * (direct * sun_visibility(altitude_m, sun.z));
  const vec3 sunlight = sun_transmittance(transmittance, altitude_m, sun.z);
  const vec3 clear_sky = sky_irradiance_from_above(sky_irradiance, altitude_m, sun.z);
  const vec3 from_sky = clear_sky + sunlight * (level * kCloudDiffuseTransmittance * (1.0 - past_clouds));
  const float sky_share = openness_at(place) * (0.5 + 0.5 * normal.z);
  const vec3 around = frame.ground_albedo * (sunlight * (kLitAround * level * past_clouds) + from_sky);
  vec3 radiance = albedo / kPi * (sunlight * direct + from_sky * sky_share + around * (1.0 - sky_share));
  for (float share = water; share > 0.0; share = 0.0)
    radiance = mix(radiance,
                   water_reflection(-seen_along.z, sun.z, -dot(direction, frame.sun_direction),
                                    sunlight * (level * past_mountains * past_clouds), clear_sky),
                   share);
  return radiance;
}

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, frame.image_size_px))) return;
  const float distance = texelFetch(distance_m, ivec2(pixel), 0).x;
  const bool hosts = view.has_host != 0u && texelFetch(host_distance, ivec2(pixel), 0).x == distance;
  if (hosts) imageStore(radiance, ivec2(pixel), texelFetch(host_radiance, ivec2(pixel), 0));
  // A loop and not a branch: a CPU driver leaves loops, and would execute the branch for sky too.
  const uint surfaces = isinf(distance) || hosts ? 0u : 1u;
  for (uint i = 0u; i < surfaces; ++i) {
    const vec3 direction = pixel_direction(vec2(pixel) + 0.5, frame.image_size_px);
    const float pixel_rad = length(pixel_direction(vec2(pixel) + vec2(0.5, 1.5), frame.image_size_px) - direction);
    imageStore(radiance, ivec2(pixel), vec4(frame.sun_irradiance * shaded(direction, distance, pixel_rad), 1.0));
  }
}
