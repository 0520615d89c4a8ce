#include "tools/clouds/grow_metaballs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/clouds/repeatable.h"

namespace nephele::clouds {

MetaballParameters::MetaballParameters() {
  skin.generations = 2;
  skin.children = 26;
}

void read_metaballs(JsonObject& json, MetaballParameters& p) {
  json.integer("seed", p.seed);
  json.integer("balls", p.balls, 1, 300);
  json.number("width_m", p.width_m, {50.0, 20000.0});
  json.number("depth_m", p.depth_m, {50.0, 20000.0});
  json.number("height_m", p.height_m, {50.0, 15000.0});
  json.number("smallest_ball_m", p.smallest_ball_m, {10.0, 5000.0});
  json.number("largest_ball_m", p.largest_ball_m, {10.0, 5000.0});
  if (p.largest_ball_m < p.smallest_ball_m)
    json.fail(json.has("smallest_ball_m") ? "smallest_ball_m" : "largest_ball_m",
              "does not fit: smallest_ball_m is above largest_ball_m");
  json.object("fill", [&](JsonObject& fill) { read_fill(fill, p.fill); });
  json.object("skin", [&](JsonObject& skin) { read_skin(skin, p.skin); });
}

double metaball_field(const std::vector<Metaball>& balls, const glm::dvec3& place_m) {
  double sum = 0.0;
  for (const Metaball& ball : balls) {
    const glm::dvec3 offset = (place_m - ball.center_m) / ball.radius_m;
    const double square = glm::dot(offset, offset);
    if (square >= 9.0) continue;
    const double end = 1.0 - square / 9.0;
    sum += 81.0 / 64.0 * end * end / std::max(square, 1e-9);
  }
  return sum;
}

std::vector<Metaball> place_metaballs(const MetaballParameters& p) {
  RandomSequence random(p.seed, 21);
  std::vector<Metaball> balls;
  for (std::uint32_t i = 0; i < p.balls; ++i) {
    const double radius = i == 0 ? p.largest_ball_m : random.size(p.smallest_ball_m, p.largest_ball_m);
    const double x = random.normal(), y = random.normal();
    const glm::dvec2 q = (i == 0 ? 0.2 : 1.0) * glm::dvec2(std::clamp(x, -2.0, 2.0), std::clamp(y, -2.0, 2.0));
    // As high as the bell over its place lets it; most are low.
    const double bell = falling_exponential(0.5 * glm::dot(q, q)), up = random.unit();
    const double top = std::max(0.0, p.height_m * bell - 1.2 * radius);
    balls.push_back(
        {{q.x * p.width_m / 4.6, q.y * p.depth_m / 4.6, (i == 0 ? 0.6 : up) * top + 0.35 * radius}, radius});
  }
  return balls;
}

Result<ParticleSet> grow_metaballs(const MetaballParameters& p) {
  const std::vector<Metaball> balls = place_metaballs(p);
  // The surface lies within the box of the balls' own reach: beyond 3 r a ball adds nothing.
  glm::dvec3 low(1e30), high(-1e30);
  for (const Metaball& ball : balls) {
    low = glm::min(low, ball.center_m - 3.0 * ball.radius_m);
    high = glm::max(high, ball.center_m + 3.0 * ball.radius_m);
  }
  low.z = -0.5 * p.fill.smallest_body_m;  // the base cuts the bodies of the lowest cells
  Result<SolidLattice> solid = lattice_around(low, high, p.fill.smallest_body_m);
  if (!solid) return solid.error();
  for (int z = 1; z + 1 < solid->size.z; ++z)
    for (int y = 1; y + 1 < solid->size.y; ++y)
      for (int x = 1; x + 1 < solid->size.x; ++x) {
        const glm::dvec3 place = solid->middle({x, y, z});
        solid->inside[solid->at(x, y, z)] = place.z > low.z && metaball_field(balls, place) > 1.0;
      }
  RandomSequence filling(p.seed, 22), growing(p.seed, 23);
  Result<std::vector<CloudBody>> bodies = fill_solid(*solid, p.fill, 0.5 * p.fill.smallest_bump_m, filling);
  if (!bodies) return bodies.error();
  if (bodies->empty()) return Error{"smallest_body_m is too large: the balls' surface holds not one cell"};
  keep_connected(*bodies);
  grow_skin(*bodies, p.skin, 0.25 * p.skin.smallest_m, growing);
  Result<ParticleSet> set = set_of_bodies(std::move(*bodies), true);
  if (!set) return set;
  set->source = "grow metaballs";
  set->parameters = parameters_text([q = p](JsonObject& json) mutable { read_metaballs(json, q); });
  return set;
}

}  // namespace nephele::clouds
