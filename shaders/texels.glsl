// Buffers read as texels. Lavapipe loads storage buffers lane by lane and word by word, but gathers a texel's four words for
// eight threads at once; hardware does either alike. What each thread reads at a place of its own comes this way.
#ifndef NEPHELE_TEXELS_GLSL
#define NEPHELE_TEXELS_GLSL

vec4 texel_at(usamplerBuffer texels, uint i) { return uintBitsToFloat(texelFetch(texels, int(i))); }
uint word_at(usamplerBuffer words, uint i) { return texelFetch(words, int(i)).x; }

#endif
