// The 4D tables of [Yusov14] 4 and 5.1, to compare ours with: the published axes, sizes, precision, number of orders
// and phase functions; right values at the vertices, which the published tables do not have everywhere.
//   paper_optical_depth        RG8, of the same noisy reference particle as our own table
//   paper_single_scattering    R16F, without the phase function
//   paper_multiple_scattering  R16F, orders 2 to 18
// Axes: shaders/shared/paper_axes.h; fetches: tests/shaders/paper_tables.glsl.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "lut/cpu_fetch.h"

namespace nephele {

using PaperSize = std::array<std::uint32_t, 4>;  // vertices along each axis

struct PaperParameters {
  std::uint32_t phase_function = 1;  // Cornette-Shanks, [Yusov14] Eq. 7
  PaperSize optical_depth_size{64, 32, 64, 32};
  PaperSize scattering_size{32, 64, 16, 8};
  std::uint32_t particle_seed = 67;

  Result<void> validate() const;
};

struct PaperTables {
  PaperParameters parameters;
  Table optical_depth, single_scattering, multiple_scattering;
};

PaperTables bake_paper_tables(const PaperParameters& parameters, const ProgressCallback& progress = {});
// The three tables as NAME.npy and NAME.json; read back, a damaged, foreign or outdated file is an error.
Result<void> save_paper_tables(const std::filesystem::path& dir, PaperTables& tables);
Result<PaperTables> load_paper_tables(const std::filesystem::path& dir);

shared::vec4 as_vector(const PaperSize& size);
shared::vec2 fetch_paper(const FloatTexture& table, const shared::vec4& axes, const shared::vec4& size);

}  // namespace nephele
