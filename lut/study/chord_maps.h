// Candidates for the axes of the optical depth table, compared without baking any: what a chord would be filtered from
// is computed when it is asked for. The table's own map is the first one (shared/table_axes.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace nephele {

struct ChordMapError {
  std::string name;
  std::array<int, 4> size{};
  double transmittance_rms = 0;  // at peak optical radius 8, over random chords
};

// Tables of about 32^4 texels, exact values at the vertices, linear filtering along all four axes.
std::vector<ChordMapError> compare_chord_maps(std::uint32_t particle_seed, int chords);

}  // namespace nephele
