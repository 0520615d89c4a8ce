#include "tools/clouds/coarser_levels.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "tools/clouds/particle_grid.h"
#include "tools/clouds/volume_fit.h"

namespace nephele::clouds {
namespace {

constexpr double kVoxelsAcross = 112.0;  // along the set's longest side
constexpr double kFewer = 0.5;           // of the level before, at most

}  // namespace

Result<void> add_coarser_levels(ParticleSet& set) {
  set.coarser.clear();
  std::vector<PlacedBody> bodies = bodies_of(set);
  const VolumeGrid whole = grid_around(bodies, 1.0);
  double longest_m = 0.0;
  for (const std::vector<double>& bounds : whole.bounds_m)
    longest_m = std::max(longest_m, bounds.back() - bounds.front());
  const double voxel_m = longest_m / kVoxelsAcross;
  VolumeGrid grid = grid_around(bodies, voxel_m);
  ParticleGrid reader(std::move(bodies), std::move(grid), std::array{0, 1, 2});
  FitOptions options;
  options.detail = set.detail;
  options.coarser_levels = kMaxCoarserLevels - 1;
  Result<VolumeFit> fit = fit_volume(reader, options);
  if (!fit) return fit.error();
  std::vector<ParticleSet> levels = std::move(fit->set.coarser);
  fit->set.coarser.clear();
  levels.insert(levels.begin(), std::move(fit->set));
  std::size_t before = set.particles.size();
  for (ParticleSet& level : levels) {
    if (static_cast<double>(level.particles.size()) > kFewer * static_cast<double>(before)) continue;
    before = level.particles.size();
    level.source = set.source;
    level.parameters = set.parameters;
    level.base_m = set.base_m;
    level.top_m = set.top_m;
    for (SetParticle& p : level.particles) {
      p.base_m = set.base_m;
      p.top_m = set.top_m;
    }
    set.coarser.push_back(std::move(level));
  }
  return {};
}

}  // namespace nephele::clouds
