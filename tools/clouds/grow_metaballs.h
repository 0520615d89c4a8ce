// A cumulus from metaballs, after [Jimenez de Parga 2018] section 3.6.3: a few balls melt into one surface, which is
// filled with bodies and gets a skin.
//
// Departs from Eq. 19, f = sum r^2 / d^2 >= 1: a ball's term never ends there, so that every ball, however far, moves
// the surface, and all must be asked everywhere. Here a term is 81/64 r^2 / d^2 (1 - d^2 / 9 r^2)^2 out to 3 r and 0
// beyond, with a smooth end; a lone ball still has its surface at d = r. The balls stand by a normal distribution on
// the condensation level, which cuts them. The paper marches through f with a mean radius (Eq. 20, 21): not needed
// here.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/result.h"
#include "tools/clouds/cloud_skin.h"
#include "tools/clouds/solid_fill.h"

namespace nephele::clouds {

struct Metaball {
  glm::dvec3 center_m{0.0};
  double radius_m = 100.0;
};

struct MetaballParameters {
  std::uint32_t seed = 1;
  std::uint32_t balls = 30;
  double width_m = 1700.0;  // about
  double depth_m = 1150.0;
  double height_m = 1050.0;
  double smallest_ball_m = 75.0;  // radii
  double largest_ball_m = 200.0;
  FillParameters fill;
  SkinParameters skin;

  MetaballParameters();
};
void read_metaballs(JsonObject& json, MetaballParameters& parameters);

// The sum of the balls' terms; inside the surface it is above 1.
double metaball_field(const std::vector<Metaball>& balls, const glm::dvec3& place_m);
std::vector<Metaball> place_metaballs(const MetaballParameters& parameters);

Result<ParticleSet> grow_metaballs(const MetaballParameters& parameters);

}  // namespace nephele::clouds
