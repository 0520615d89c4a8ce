// The importer's moments added up on the device: the set is that of the CPU, to the rounding of floats.
#include "tools/clouds/device_nodes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "tests/support/test_device.h"
#include "tools/sample_volume/cumulus_volume.h"

using namespace nephele;
using namespace nephele::clouds;
using nephele::test::test_device;

namespace {

// With levels of uneven height where asked for.
MemoryVolume cumulus(std::size_t n, bool uneven) {
  std::vector<float> values(n * n * n);
  sample::for_cumulus_voxels(
      n, {}, [&](std::size_t x, std::size_t y, std::size_t z, float value) { values[(z * n + y) * n + x] = value; });
  VolumeGrid grid;
  const double voxel_m = sample::kCumulusSideM / static_cast<double>(n);
  for (std::vector<double>& bounds : grid.bounds_m) bounds = even_bounds(n, 0.0, voxel_m);
  if (uneven)
    for (double& height_m : grid.bounds_m[2]) height_m += 2e-4 * height_m * height_m;
  grid.anchor_m = {12345.0, -678.0, 90.0};
  return MemoryVolume(std::move(grid), std::move(values));
}

}  // namespace

TEST_CASE("device nodes: particles of a volume are those that the CPU makes") {
  for (const bool uneven : {false, true})
    for (const double edge : {0.0, 0.7, 1.0}) {
      CAPTURE(uneven);
      CAPTURE(edge);
      MemoryVolume volume = cumulus(48, uneven);
      const FitOptions options{.spacing_voxels = 3.0, .soft_edge = edge};
      const Result<VolumeFit> expected = fit_volume(volume, options);
      REQUIRE(expected);
      FitStats stats;
      Result<NodeLattice> nodes = gather_nodes_on(test_device(), volume, options, &stats);
      REQUIRE(nodes);
      CHECK(stats.occupied_voxels == expected->stats.occupied_voxels);
      CHECK(std::abs(stats.mass_m2 / expected->stats.mass_m2 - 1.0) < 1e-5);
      const Result<VolumeFit> made = fit_of_nodes(std::move(*nodes), stats, options);
      REQUIRE(made);
      REQUIRE(made->set.particles.size() == expected->set.particles.size());
      REQUIRE(made->set.coarser.size() == expected->set.coarser.size());
      double worst_place = 0.0, worst_shape = 0.0, worst_mass = 0.0;
      std::size_t apart = 0;
      for (std::size_t i = 0; i < made->set.particles.size(); ++i) {
        const SetParticle &a = made->set.particles[i], &b = expected->set.particles[i];
        CHECK(a.seed == b.seed);
        apart += a.base_m != b.base_m || a.top_m != b.top_m;
        worst_place = std::max(worst_place, static_cast<double>(glm::length(a.center_m - b.center_m)));
        worst_shape = std::max(worst_shape, static_cast<double>(glm::length(a.diagonal_m - b.diagonal_m) +
                                                                glm::length(a.off_diagonal_m - b.off_diagonal_m)) /
                                                static_cast<double>(glm::length(b.diagonal_m)));
        worst_mass = std::max(worst_mass, std::abs(static_cast<double>(a.extinction_per_m / b.extinction_per_m) - 1.0));
      }
      // Sums of some 300 floats, squares of 100 m of which a variance of 1000 m2 is left, whose root is taken; a
      // variance near 0 loses more of its digits, and so does the density of so flat a particle.
      CHECK(apart == 0);
      CHECK(worst_place < 2e-2);
      CHECK(worst_shape < 5e-3);
      CHECK(worst_mass < 5e-2);
    }
}

TEST_CASE("device nodes: windows of too many voxels are refused") {
  MemoryVolume volume = cumulus(64, false);
  const Result<NodeLattice> nodes =
      gather_nodes_on(test_device(), volume, {.spacing_voxels = 30.0, .vertical_spacing_voxels = 30.0});
  REQUIRE_FALSE(nodes);
  CHECK(nodes.error().message.find("a window holds ") == 0);
}
