// The image darker towards its corners, as a wide lens draws it.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) uniform image2D hdr;
layout(push_constant) uniform Push { float strength; };

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = imageSize(hdr);
  if (any(greaterThanEqual(at, size))) return;
  vec2 from_center = (vec2(at) + 0.5) / vec2(size) - 0.5;
  vec4 color = imageLoad(hdr, at);
  imageStore(hdr, at, vec4(color.rgb * (1.0 - strength * dot(from_center, from_center)), color.a));
}
