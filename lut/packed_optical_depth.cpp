#include "lut/packed_optical_depth.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shared/table_axes.h"

namespace nephele {

std::vector<std::uint32_t> pack_optical_depth(const Table& optical_depth) {
  const std::uint32_t n = optical_depth.width();
  // Value of a channel at vertex (E.u, E.v, S.u, S.v), as a byte.
  const auto byte_at = [&](const glm::uvec4& vertex, std::uint32_t channel) {
    const std::size_t texel = ((std::size_t{vertex.w} * n + vertex.z) * n + vertex.y) * n + vertex.x;
    std::uint16_t half = 0;
    std::memcpy(&half, &optical_depth.array.data[2 * (2 * texel + channel)], sizeof half);
    return static_cast<std::uint32_t>(std::clamp(std::lround(glm::unpackHalf2x16(half).x * 256.0f), 0l, 255l));
  };
  std::vector<std::uint32_t> words(shared::packed_words(n) + shared::packed_words(shared::coarse_vertices(n)));
  // vertex_of: the table's vertex for one of `side` along an axis.
  const auto pack = [&](std::uint32_t first, std::uint32_t side, std::uint32_t channel, const auto& vertex_of) {
    for (std::uint32_t w = 0; w < side; ++w)
      for (std::uint32_t z = 0; z < side; ++z)
        for (std::uint32_t y = 0; y < side; ++y)
          for (std::uint32_t group = 0; group < shared::packed_groups(side); ++group) {
            std::uint32_t word = 0;
            for (std::uint32_t k = 0; k < 4; ++k) {
              const std::uint32_t x = std::min(3 * group + k, side - 1);
              word |= byte_at({vertex_of(x), vertex_of(y), vertex_of(z), vertex_of(w)}, channel) << (8 * k);
            }
            words[first + shared::packed_along_exit_u(group, side) + shared::packed_along_exit_v(y) +
                  shared::packed_along_entry_u(z, side) + shared::packed_along_entry_v(w, side)] = word;
          }
  };
  pack(0, n, 0, [](std::uint32_t i) { return i; });
  pack(shared::packed_words(n), shared::coarse_vertices(n), 1,
       [&](std::uint32_t i) { return shared::coarse_vertex(i, n); });
  return words;
}

}  // namespace nephele
