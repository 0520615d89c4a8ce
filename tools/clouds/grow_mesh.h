// A cloud in the shape of a mesh, after [Jimenez de Parga 2018] section 3.6.4.
//
// Departs from the paper, which puts an ellipsoid around each triangle (Eq. 22 to 30): that leaves a shell whose bodies
// show the triangles, and whose three radii along the world's axes are not those of the triangle. Here the mesh is
// filled with bodies whose size follows the distance to its surface, and gets bumps and a skin, so that its outline
// stays and its triangles do not. Meshes need not be closed: a place is inside where at least two of three rays, along
// the axes, cross the surface an odd number of times.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/result.h"
#include "tools/clouds/cloud_skin.h"
#include "tools/clouds/mesh_reader.h"
#include "tools/clouds/solid_fill.h"

namespace nephele::clouds {

enum class UpAxis { y, z };

struct MeshParameters {
  std::uint32_t seed = 1;
  double width_m = 1500.0;  // the larger horizontal extent that the mesh is scaled to
  UpAxis up = UpAxis::y;    // of the mesh
  bool flat_base = false;   // cut at base_share of the height; without: nothing is cut
  double base_share = 0.1;
  FillParameters fill;
  SkinParameters skin;

  MeshParameters();
};
void read_mesh_parameters(JsonObject& json, MeshParameters& parameters);

// The triangles' inside on a lattice. Their box is the lattice's but for a margin.
Result<SolidLattice> solid_of_triangles(const std::vector<Triangle>& triangles, double smallest_body_m);

// Triangles in the mesh's own units.
Result<ParticleSet> grow_mesh(const MeshParameters& parameters, const std::vector<Triangle>& triangles);

}  // namespace nephele::clouds
