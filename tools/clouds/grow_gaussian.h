// A cumulus from normal distributions, after [Jimenez de Parga 2018] section 3.6.1: a bed on the condensation level,
// towers on it, and a skin of turrets.
//
// Departs from the paper, whose 35 spheres on their own look like cotton balls in a row:
// - Eq. 15 takes a sphere's radius from its place in the world, so a cloud changes as it is moved. Here all places are
//   the cloud's own.
// - Eq. 16 multiplies three squares that are meant to be added: the product is near 0 nearly everywhere and all radii
//   come out alike. Here a bell, exp(-(x^2 / sx^2 + y^2 / sy^2) / 2), decides how high towers grow and where the bed
//   ends, and sizes follow a power law.
// - The filter that hollows the cloud out is left out, since light needs the inside; so is Eq. 17, which drops spheres
//   inside of others: the skin alone asks what hides it.
// - One bell makes a round heap. Here a few, of which each seed has others, are joined.
#pragma once

#include <cstdint>

#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/result.h"
#include "tools/clouds/cloud_skin.h"

namespace nephele::clouds {

struct GaussianParameters {
  std::uint32_t seed = 1;
  double width_m = 1700.0;  // of the bed along x, about
  double depth_m = 1350.0;  // along y
  double height_m = 1000.0;
  std::uint32_t towers = 34;
  double smallest_tower_m = 100.0;  // radius
  double largest_tower_m = 290.0;
  double lean_deg = 10.0;  // of the towers, all one way, each by its own share
  double asymmetry = 0.7;  // 0: one bell
  double extinction_per_m = 0.05;
  SkinParameters skin;
};
void read_gaussian(JsonObject& json, GaussianParameters& parameters);

Result<ParticleSet> grow_gaussian(const GaussianParameters& parameters);

}  // namespace nephele::clouds
