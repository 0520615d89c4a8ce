// The baked tables: what they are made from, where they are cached, how to get them.
//   optical depth        of the noisy reference particle along every chord, RG16F, N x N x N^2
//   multiple scattering  of the homogeneous sphere, cubic coefficients, RGBA16F
//   near beam            of light scattered little from the sun's beam (lut/near_beam.h), R16F
// Single scattering needs no table (shaders/shared/scattering.h). Axes: shaders/shared/table_axes.h and
// near_beam_axes.h; fetches: shaders/layer/table_fetch.glsl.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/npy.h"
#include "engine/result.h"

namespace nephele {

inline constexpr double kMinResidual = 1e-7, kMaxResidual = 1e-2;

struct TableParameters {
  std::uint32_t phase_function = 0;         // shared::kPhaseHenyeyGreenstein or kPhaseCornetteShanks
  double g_single = 0.85;                   // of single scattering; evaluated while shading, bakes nothing
  double g_multiple = 0.85;                 // of orders >= 2, -0.95 .. 0.95
  std::uint32_t optical_depth_size = 32;    // vertices along a side of each octahedral map, 4 .. 64
  std::uint32_t scattering_cosines = 48;    // texels along c, 4 .. 128
  std::uint32_t scattering_chords = 24;     // along h, 3 .. 128
  std::uint32_t scattering_densities = 16;  // along the density axis, 4 .. 64
  bool coarse_solver = false;               // the thin particles' grid for every density
  double residual = 3e-5;            // relative, at which a solution counts as converged, kMinResidual .. kMaxResidual
  std::uint32_t particle_seed = 67;  // of the reference particle

  static Result<TableParameters> preset(const std::string& name);  // default, fast
  Result<void> validate() const;
};

struct Table {
  std::string name;                 // file name without extension
  NpyArray array;                   // slowest axis first, channels last
  std::string metadata;             // the text of its JSON file
  std::filesystem::path json_path;  // that file; empty for a table that was only baked

  // Texels of the 3D texture: width is the fastest axis.
  std::uint32_t width() const { return static_cast<std::uint32_t>(array.shape[2]); }
  std::uint32_t height() const { return static_cast<std::uint32_t>(array.shape[1]); }
  std::uint32_t depth() const { return static_cast<std::uint32_t>(array.shape[0]); }
};

struct Tables {
  TableParameters parameters;
  Table optical_depth;
  Table multiple_scattering;
  Table near_beam;
  float mean_fill = 0;  // of the reference particle: its mean extinction over the sphere divided by the peak
};

// Called from the baking threads' owner: what is being baked and how much of it is done, 0 .. 1.
using ProgressCallback = std::function<void(const std::string& stage, double fraction)>;
using WarningCallback = std::function<void(const std::string& line)>;

// $XDG_CACHE_HOME/nephele, else ~/.cache/nephele, else a directory of the system's temporary one.
std::filesystem::path default_cache_dir();

// Reads the tables from cache_dir, or bakes and stores them there. A damaged or foreign file is reported through `warn`
// (default: stderr) and baked again; so is a cache that cannot be written. An error only for bad parameters.
Result<Tables> load_or_bake(const TableParameters& parameters, const std::filesystem::path& cache_dir,
                            const ProgressCallback& progress = {}, const WarningCallback& warn = {});

// Bakes all tables and writes them to dir as optical_depth.npy/.json, multiple_scattering and near_beam alike.
Result<Tables> bake_to(const std::filesystem::path& dir, const TableParameters& parameters,
                       const ProgressCallback& progress = {});

// The tables as bake_to wrote them; a damaged, foreign or outdated file is an error.
Result<Tables> load_tables(const std::filesystem::path& dir);

// One table with its metadata; everything that can be checked is (shape, type, size, hash, parameters).
Result<Table> load_table(const std::filesystem::path& json_path);
Result<void> save_table(const std::filesystem::path& dir, const std::string& file_stem, const Table& table);
// The JSON alone, where the table came from or went to.
Result<void> save_metadata(const Table& table);

Table bake_optical_depth(const TableParameters& parameters, const ProgressCallback& progress = {});
Table bake_multiple_scattering(const TableParameters& parameters, const ProgressCallback& progress = {});
Table bake_near_beam(const TableParameters& parameters);

}  // namespace nephele
