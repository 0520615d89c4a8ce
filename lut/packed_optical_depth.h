// The optical depth table packed into bytes (shared/table_axes.h), for devices without a texture unit of their own.
#pragma once

#include <cstdint>
#include <vector>

#include "lut/tables.h"

namespace nephele {

// The words that fetch_packed_optical_depth of shaders/layer/packed_table_fetch.glsl reads. Exact for tables that
// bake_optical_depth_array made: their values are whole 256ths.
std::vector<std::uint32_t> pack_optical_depth(const Table& optical_depth);

}  // namespace nephele
