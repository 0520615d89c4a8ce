// The density inside the reference particle, sampled. The including shader declares sampler3D particle_density.
#ifndef NEPHELE_DENSITY_FETCH_GLSL
#define NEPHELE_DENSITY_FETCH_GLSL

// Extinction over the peak at a place of reference space; 0 outside the unit sphere.
float density_in_particle(vec3 p) {
  const float cells = float(textureSize(particle_density, 0).x - 1);
  return textureLod(particle_density, ((0.5 * p + 0.5) * cells + 0.5) / (cells + 1.0), 0.0).x;
}

#endif
