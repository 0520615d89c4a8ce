// Coarser levels for a set that has none: its particles as a volume, and that as particles again (volume_fit.h).
#pragma once

#include "engine/particle_set.h"
#include "engine/result.h"

namespace nephele::clouds {

// Fills in `coarser`. The levels are of soft particles, each at most half as many as the one before; they have the
// set's matter, base and top. A set of few particles gets none.
Result<void> add_coarser_levels(ParticleSet& set);

}  // namespace nephele::clouds
