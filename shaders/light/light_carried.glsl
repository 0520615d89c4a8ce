// What a cell's moments hold (light_moments.comp). The including shader declares LightLattice lattice and
// TEXELS moments.
#ifndef NEPHELE_LIGHT_CARRIED_GLSL
#define NEPHELE_LIGHT_CARRIED_GLSL

// What a listed cell scatters into a direction of the light that has left the beam, as the radiance of matter that is
// opaque, in units of frame.light_unit.
vec3 carried_towards(uint cell, vec3 direction) {
  const LightHarmonics h = light_harmonics(direction);
  float m[28];
  for (uint k = 0u; k < 4u; ++k) {
    const uvec4 texel = texel_at(moments, 4u * cell + k);
    for (uint j = 0u; j < (k == 3u ? 2u : 4u); ++j) {
      const vec2 two = unpackHalf2x16(texel[j]);
      m[8u * k + 2u * j] = two.x;
      m[8u * k + 2u * j + 1u] = two.y;
    }
  }
  vec3 seen = vec3(m[0], m[1], m[2]);
  for (uint k = 1u; k < kLightMoments; ++k)
    seen += (k < 4u ? lattice.moment1 : lattice.moment2) * h.y[k] * vec3(m[3u * k], m[3u * k + 1u], m[3u * k + 2u]);
  return max(seen, vec3(0.0));
}

#endif
