// What the ray marcher knows of its own noise.
#ifndef NEPHELE_MARCH_NOISE_GLSL
#define NEPHELE_MARCH_NOISE_GLSL

float luminance_of(vec3 radiance) { return dot(radiance, vec3(0.2126, 0.7152, 0.0722)); }

// The two of a pixel that are compared: transmittance and luminance.
vec2 noisy_value(vec4 color) { return vec2(color.a, luminance_of(color.rgb)); }

#endif
