// Shades a particle and blends it into its pixel, back to front. Three ways to own the pixel's state:
// attachment (rasterization-order input attachments), interlock (storage images), alpha (fixed-function baseline).
// variants: attachment=BLEND_ATTACHMENT interlock=BLEND_INTERLOCK alpha=BLEND_ALPHA
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef BLEND_INTERLOCK
#extension GL_ARB_fragment_shader_interlock : require
layout(pixel_interlock_ordered) in;
#endif
#include "shared/types.h"

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) readonly buffer DrawParticles { DrawParticle draw_particles[]; };
layout(set = 0, binding = 8) uniform sampler2D layer_scene;  // metres to what stands behind
layout(location = 0) flat in uint particle_index;

#include "layer/cloud_shade.glsl"
#include "layer/blend_state.glsl"

#if defined(BLEND_ATTACHMENT)
layout(input_attachment_index = 0, set = 0, binding = 5) uniform subpassInput open_in;
layout(input_attachment_index = 1, set = 0, binding = 6) uniform subpassInput extent_in;
layout(input_attachment_index = 2, set = 0, binding = 7) uniform subpassInput committed_in;
layout(location = 0) out vec4 open_out;
layout(location = 1) out vec4 extent_out;
layout(location = 2) out vec4 committed_out;
#elif defined(BLEND_INTERLOCK)
layout(set = 0, binding = 5, rgba32f) uniform coherent image2D open_image;
layout(set = 0, binding = 6, rgba32f) uniform coherent image2D extent_image;
layout(set = 0, binding = 7, rgba32f) uniform coherent image2D committed_image;
#else
layout(location = 0) out vec4 color_out;  // premultiplied radiance, opacity
layout(location = 1) out float first_out;
#endif

void main() {
  const vec3 direction = pixel_direction(gl_FragCoord.xy * float(frame.scale), frame.image_size_px);
  BlendSegment segment;
  const bool visible = shade_particle(draw_particles[particle_index], direction,
                                      texelFetch(layer_scene, ivec2(gl_FragCoord.xy), 0).x, segment);

#if defined(BLEND_ATTACHMENT)
  if (!visible) discard;
  BlendState state = unpack_blend_state(subpassLoad(open_in), subpassLoad(extent_in), subpassLoad(committed_in));
  blend_add(state, segment);
  pack_blend_state(state, open_out, extent_out, committed_out);
#elif defined(BLEND_INTERLOCK)
  const ivec2 at = ivec2(gl_FragCoord.xy);
  beginInvocationInterlockARB();
  if (visible) {
    BlendState state =
        unpack_blend_state(imageLoad(open_image, at), imageLoad(extent_image, at), imageLoad(committed_image, at));
    blend_add(state, segment);
    vec4 open_out, extent_out, committed_out;
    pack_blend_state(state, open_out, extent_out, committed_out);
    imageStore(open_image, at, open_out);
    imageStore(extent_image, at, extent_out);
    imageStore(committed_image, at, committed_out);
  }
  endInvocationInterlockARB();
#else
  if (!visible) discard;
  const float alpha = opacity_of(segment.extinction_per_m * (segment.far_m - segment.near_m));
  color_out = vec4(segment.radiance * alpha, alpha);
  first_out = segment.near_m;
#endif
}
