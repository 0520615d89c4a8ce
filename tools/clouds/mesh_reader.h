// Triangles of a mesh file, through the library assimp.
//
// That library may crash, hang or take all memory on a damaged file. So it runs in a process of its own with limits,
// which hands the triangles back through a pipe; whatever happens to it becomes an error here.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "engine/result.h"

namespace nephele::clouds {

using Triangle = std::array<glm::dvec3, 3>;

inline constexpr std::size_t kMaxTriangles = 200000;
inline constexpr std::size_t kMaxMeshBytes = std::size_t{64} << 20;

// .obj or .ply, by the path's ending. Vertices that are not finite, or beyond 1e9, no triangle with an area and more
// than kMaxTriangles are errors. In the file's own units and axes; triangles without area are left out.
Result<std::vector<Triangle>> read_mesh(const std::string& path);

}  // namespace nephele::clouds
