// The weather map: coverage and type of the clouds over the ground, from an image that lies in the world.
//
// The map stands still over the ground, the clouds drift through it with the wind. A shader that has it in a buffer
// defines NEPHELE_WEATHER_TEXEL(weather, i), texel i as red | green << 8, before including the file.
#ifndef NEPHELE_SHARED_WEATHER_H
#define NEPHELE_SHARED_WEATHER_H

#include "field_constants.h"

NEPHELE_SHARED_BEGIN

struct Weather {
  WeatherPlacement placement;
  float coverage;  // beyond the map
#ifdef __cplusplus
  const uint* texels = nullptr;  // as in the buffer
#endif
};

#ifdef __cplusplus
#define NEPHELE_WEATHER_TEXEL(weather, i) weather.texels[i]
#elif !defined(NEPHELE_WEATHER_TEXEL)
#define NEPHELE_WEATHER_TEXEL(weather, i) 0u
#endif

NEPHELE_CONST(float, kCongestus, 1.0f);  // of type: the clouds that there are without a map; 0 is humilis

NEPHELE_FN bool has_weather_map(Weather weather) { return weather.placement.size.x > 0; }

NEPHELE_CONST(float, kWeatherBorderM, 2000.0f);  // beyond the map, over which it fades into what holds outside

// Coverage and type at a texel, its row counted from the south; the image's first row is the northernmost. The map's
// outermost texels go on beyond it.
NEPHELE_FN vec2 weather_texel(Weather weather, ivec2 at) {
  ivec2 size = weather.placement.size;
  ivec2 inside = clamp(at, ivec2(0), size - 1);
  uint texel = NEPHELE_WEATHER_TEXEL(weather, (size.y - 1 - inside.y) * size.x + inside.x);
  return vec2(float(texel & 255u), float((texel >> 8u) & 255u)) * (1.0f / 255.0f);
}

// Coverage (x) and type (y) at a place in grid space, bilinear between the middles of texels; outside the map the
// scene's own coverage, and the type of clouds without a map. Continuous everywhere.
NEPHELE_FN vec2 weather_at(Weather weather, vec2 p_grid_m) {
  vec2 beyond = vec2(weather.coverage, kCongestus);
  vec2 t = p_grid_m * weather.placement.per_m + weather.placement.offset;
  vec2 cell = floor(t);
  vec2 f = t - cell;
  ivec2 at = weather.placement.base + ivec2(cell);
  vec2 from_south_west = vec2(at) + f + 0.5f;
  vec2 outside_m = max(-from_south_west, from_south_west - vec2(weather.placement.size)) / weather.placement.per_m;
  float away = max(outside_m.x, outside_m.y) * (1.0f / kWeatherBorderM);
  if (away >= 1.0f) return beyond;
  vec2 south = mix(weather_texel(weather, at), weather_texel(weather, at + ivec2(1, 0)), f.x);
  vec2 north = mix(weather_texel(weather, at + ivec2(0, 1)), weather_texel(weather, at + ivec2(1, 1)), f.x);
  return mix(mix(south, north, f.y), beyond, max(away, 0.0f));
}

#ifdef __cplusplus
// grid_origin_m: of grid space, in the world's own coordinates (with the wind's drift). corner_m: the map's south-west
// one.
inline WeatherPlacement weather_placement(ivec2 size, dvec2 corner_m, dvec2 extent_m, dvec2 grid_origin_m) {
  const dvec2 per_m = dvec2(size) / extent_m;
  const dvec2 origin = (grid_origin_m - corner_m) * per_m - 0.5;
  const dvec2 whole = floor(origin);
  // A map so far away that its index would not fit is out of reach of every place that is asked for.
  return {size, ivec2(clamp(whole, dvec2(-1e9), dvec2(1e9))), vec2(origin - whole), vec2(per_m)};
}
#endif

NEPHELE_SHARED_END

#endif
