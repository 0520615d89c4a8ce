// A dispatch of one thread a (tile, item) pair, 64 a group. Vulkan guarantees 65 535 groups a row and pairs may be
// more, so the groups stand in rows.
#ifndef NEPHELE_PAIR_DISPATCH_GLSL
#define NEPHELE_PAIR_DISPATCH_GLSL

const uint kGroupsInRow = 65535u;

uvec3 pair_groups(uint pair_count) {
  const uint groups = (pair_count + 63u) / 64u;
  return uvec3(min(groups, kGroupsInRow), max((groups + kGroupsInRow - 1u) / kGroupsInRow, 1u), 1u);
}

// The pair of this thread; the last row's may lie past the last pair.
uint pair_of_thread() {
  return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
}

#endif
