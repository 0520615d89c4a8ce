// The cloud layer from its low resolution to the image's: the four nearest low-resolution pixels, weighted by distance
// and by how well the scene behind them (ground or sky) agrees with that behind the full-resolution pixel, so that
// neither cloud nor sky bleeds across the horizon or an object's edge. The including shader declares layer_color,
// layer_depth and layer_scene, and includes scene_distance.glsl.
#ifndef NEPHELE_CLOUD_UPSCALE_GLSL
#define NEPHELE_CLOUD_UPSCALE_GLSL

// Logarithm of a distance; the sky counts as 10 000 km away.
float log_distance(float distance_m) { return log(clamp(distance_m, 0.01, 1e7)); }

// Premultiplied radiance and transmittance at a place of the image; first_m: metres to the first matter, +inf without.
// scene_edges: the scene may change abruptly nearby (kMixed tiles of composite_tiles.glsl).
vec4 upscaled(vec2 center_px, bool scene_edges, out float first_m) {
  const vec2 low = center_px / float(frame.scale) - 0.5;
  const ivec2 corner = ivec2(floor(low));
  const vec2 f = low - vec2(corner);
  const float own = scene_edges ? log_distance(scene_distance_m(center_px)) : 0.0;
  vec4 color = vec4(0.0);
  float weights = 0.0, depth_weights = 0.0, inverse_depth = 0.0;
  for (int i = 0; i < 4; ++i) {
    const ivec2 offset = ivec2(i & 1, i >> 1);
    const ivec2 at = clamp(corner + offset, ivec2(0), ivec2(frame.layer_size_px) - 1);
    const float bilinear = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
    float weight = bilinear + 1e-4;
    if (scene_edges) weight *= exp(-8.0 * min(abs(own - log_distance(texelFetch(layer_scene, at, 0).x)), 4.0));
    const vec4 texel = texelFetch(layer_color, at, 0);
    const float first = texelFetch(layer_depth, at, 0).x;
    color += weight * texel;
    weights += weight;
    if (!isinf(first)) {  // inverse distances: near matter decides, as in perspective
      inverse_depth += weight * (1.0 - texel.a) / first;
      depth_weights += weight * (1.0 - texel.a);
    }
  }
  first_m = inverse_depth > 0.0 ? depth_weights / inverse_depth : uintBitsToFloat(0x7f800000u);
  return color / weights;
}

#endif
