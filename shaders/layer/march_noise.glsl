// The measure of noise that the ray marcher writes and its reconstruction reads.
#ifndef NEPHELE_MARCH_NOISE_GLSL
#define NEPHELE_MARCH_NOISE_GLSL

float luminance_of(vec3 radiance) { return dot(radiance, vec3(0.2126, 0.7152, 0.0722)); }

#endif
