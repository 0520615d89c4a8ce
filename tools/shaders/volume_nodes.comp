// The moments of every node's window of a volume (shared/volume_moments.h), one thread a node: the sums of
// tools/clouds/volume_fit.cpp in floats, in the same order, each node by itself, so that no thread waits for another.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 64) in;

// What one voxel along one axis does to moments.
struct AxisStep {
  uint node;       // the lower of the two nodes that it lies between
  vec2 share;      // of the lower node, of the upper one
  vec2 from_m;     // from the node
  vec2 square_m2;  // mean square distance of the voxel's matter from the node
  float thickness_m;
  float low_m, high_m;
};

struct NodeMoments {
  float mass_m2;
  vec3 first;
  vec3 diagonal;
  vec3 off_diagonal;
  float low_m, high_m;  // of the voxels in it that can be seen; high below low: there are none
};

layout(scalar, set = 0, binding = 0) readonly buffer Voxels { float voxels[]; };   // 1/m, x fastest
layout(scalar, set = 0, binding = 1) readonly buffer Steps { AxisStep steps[]; };  // of x, then y, then z
layout(scalar, set = 0, binding = 2) readonly buffer Begins { uint begins[]; };    // a node's first step; of x, y, z
layout(scalar, set = 0, binding = 3) readonly buffer Ends { uint ends[]; };        // one past its last
layout(scalar, set = 0, binding = 4) writeonly buffer Nodes { NodeMoments nodes[]; };
layout(push_constant, scalar) uniform Push {
  uvec3 node_count;
  uvec2 voxel_count;  // along x and y
  uvec3 first_step;   // of each axis
  uvec3 first_node;   // of each axis in begins and ends
  float faintest_per_m;
};

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= node_count.x * node_count.y * node_count.z) return;
  const uvec3 node = uvec3(i % node_count.x, i / node_count.x % node_count.y, i / (node_count.x * node_count.y));
  NodeMoments sum = NodeMoments(0.0, vec3(0.0), vec3(0.0), vec3(0.0), 1.0e30, -1.0e30);
  for (uint z = begins[first_node.z + node.z]; z < ends[first_node.z + node.z]; ++z) {
    const AxisStep c = steps[first_step.z + z];
    const uint upper_z = node.z - c.node;
    float plane = 0.0, plane_x = 0.0, plane_y = 0.0, plane_xx = 0.0, plane_yy = 0.0, plane_xy = 0.0;
    bool seen = false;
    for (uint y = begins[first_node.y + node.y]; y < ends[first_node.y + node.y]; ++y) {
      const AxisStep b = steps[first_step.y + y];
      const uint upper_y = node.y - b.node;
      float row = 0.0, row_x = 0.0, row_xx = 0.0;
      for (uint x = begins[first_node.x + node.x]; x < ends[first_node.x + node.x]; ++x) {
        const float value = voxels[(z * voxel_count.y + y) * voxel_count.x + x];
        if (!(value > 0.0)) continue;
        const AxisStep a = steps[first_step.x + x];
        const uint upper_x = node.x - a.node;
        if (a.share[upper_x] == 0.0) continue;
        const float m = a.share[upper_x] * a.thickness_m * value;
        row += m;
        row_x += m * a.from_m[upper_x];
        row_xx += m * a.square_m2[upper_x];
        seen = seen || (value > faintest_per_m && b.share[upper_y] > 0.0);
      }
      const float w = b.share[upper_y] * b.thickness_m, d = b.from_m[upper_y];
      plane += w * row;
      plane_x += w * row_x;
      plane_xx += w * row_xx;
      plane_y += w * d * row;
      plane_yy += w * b.square_m2[upper_y] * row;
      plane_xy += w * d * row_x;
    }
    const float w = c.share[upper_z] * c.thickness_m, d = c.from_m[upper_z];
    if (w == 0.0) continue;
    sum.mass_m2 += w * plane;
    sum.first += w * vec3(plane_x, plane_y, d * plane);
    sum.diagonal += w * vec3(plane_xx, plane_yy, c.square_m2[upper_z] * plane);
    sum.off_diagonal += w * vec3(plane_xy, d * plane_x, d * plane_y);
    if (seen) {
      sum.low_m = min(sum.low_m, c.low_m);
      sum.high_m = max(sum.high_m, c.high_m);
    }
  }
  nodes[i] = sum;
}
