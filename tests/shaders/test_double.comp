// Engine test: doubles n values; n comes as a push constant, so that past-the-end threads do nothing.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) readonly buffer Source { uint source[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer Target { uint target[]; };
layout(push_constant, scalar) uniform Push { uint count; };
void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < count) target[i] = 2u * source[i];
}
