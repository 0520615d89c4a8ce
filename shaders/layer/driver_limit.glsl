// Lavapipe ends all loops of eight threads once they have gone round 65 535 times in all; from then on none goes round
// twice. Ask after all other loops: the result is true where the driver has ended them, so that it can be counted.
// `twice` is a number of at least 2 that the compiler does not know.
#ifndef NEPHELE_DRIVER_LIMIT_GLSL
#define NEPHELE_DRIVER_LIMIT_GLSL

bool loops_were_ended(uint twice) {
  uint rounds = 0u;
  while (rounds < twice) ++rounds;
  return rounds < 2u;
}

#endif
