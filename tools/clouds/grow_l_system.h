// A cumulus from a stochastic grammar and a turtle in space, after [Jimenez de Parga 2018] section 3.6.2.
//
// The axiom is rewritten a number of times: each symbol that has rules becomes the text of one of them, drawn by
// weight. Then a turtle reads the result:
//   letters listed in "bodies"   go forward and leave a body
//   f                            go forward
//   + -                          turn left, right        & ^   pitch down, up        \ /   roll left, right
//   !                            bodies are smaller from here on                     "     steps are shorter
//   [ ]                          remember place, directions and sizes; go back to them
//   other letters                nothing
// Turns, steps and radii vary by chance. The published grammar, Eq. 18 (X -> X+Y, Y -> X&Y), is
// tools/clouds/examples/published_l_system.json.
//
// Departs from the paper: its grammar has no branches and knows no up, so it gives a ring or a lump, as its angle is
// small or large, without base and crown. The rules here by default let stems creep along the condensation level and
// send up shoots that fork and thin out, and all bodies get a skin.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/result.h"
#include "tools/clouds/cloud_skin.h"
#include "tools/clouds/repeatable.h"

namespace nephele::clouds {

struct GrammarRule {
  std::string symbol;   // one letter
  std::string becomes;  // "" only where nothing was read
  double weight = 1.0;
};

struct LSystemParameters {
  std::uint32_t seed = 1;
  std::string axiom;
  std::vector<GrammarRule> rules;
  std::string bodies = "F";
  std::uint32_t generations = 6;
  double start_pitch_deg = 0.0;  // of the turtle, up from the horizon
  double angle_deg = 30.0;
  double angle_spread_deg = 16.0;
  double step_m = 120.0;
  double step_spread = 0.25;  // as a share
  double step_shrink = 0.85;  // what " leaves
  double radius_m = 170.0;
  double radius_spread = 0.3;
  double radius_shrink = 0.84;  // what ! leaves
  double rise = 0.0;            // how far each step turns the turtle upwards, 1: all the way
  bool flat_base = true;        // cut at the height that the turtle started at
  double extinction_per_m = 0.05;
  SkinParameters skin;

  LSystemParameters();  // axiom and rules of a cumulus
};
void read_l_system(JsonObject& json, LSystemParameters& parameters);

inline constexpr std::size_t kMaxSymbols = 1000000;

// The axiom rewritten. Longer than kMaxSymbols: an error.
Result<std::string> expand_grammar(const LSystemParameters& parameters, RandomSequence& random);

// What the turtle leaves, without skin.
Result<std::vector<CloudBody>> turtle_bodies(const LSystemParameters& parameters);

Result<ParticleSet> grow_l_system(const LSystemParameters& parameters);

}  // namespace nephele::clouds
