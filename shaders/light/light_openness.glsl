// How open a window's cells lie, ring by ring: a ring is all directions of one height over the horizon, and rings lie
// closer towards it.
#ifndef NEPHELE_LIGHT_OPENNESS_GLSL
#define NEPHELE_LIGHT_OPENNESS_GLSL

const uint kOpennessRings = 24u;

// Cosine of a ring's angle to the zenith; and the ring, with a fraction, of a cosine.
float openness_cosine(uint ring) {
  const float u = 2.0 * (float(ring) + 0.5) / float(kOpennessRings) - 1.0;
  return u * abs(u);
}
float openness_ring(float cosine) {
  const float u = sign(cosine) * sqrt(abs(cosine));
  return clamp((0.5 * u + 0.5) * float(kOpennessRings) - 0.5, 0.0, float(kOpennessRings) - 1.0);
}

// A direction that lies around the lattice: sky and air, what share of the ground's light comes through the air, and
// how many times as open the cells lie towards it as towards the ordinate that stands for it.
struct LightSeen {
  vec3 radiance, of_ground;
  float openness;
};

#endif
