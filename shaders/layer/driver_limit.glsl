// Lavapipe ends all loops of eight threads once they have gone round 65 535 times in all; from then on none goes round
// twice. To be asked last: true where that has happened, so that it can be counted. twice: some number that is at least
// 2, and that the compiler does not know.
#ifndef NEPHELE_DRIVER_LIMIT_GLSL
#define NEPHELE_DRIVER_LIMIT_GLSL

bool loops_were_ended(uint twice) {
  uint rounds = 0u;
  while (rounds < twice) ++rounds;
  return rounds < 2u;
}

#endif
