// What a person, a gamepad or a script asks of the viewer in one frame, free of any window.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace nephele::fly {

// Things that happen once, at the press of a key or a button.
enum class Action : std::uint8_t {
  level_out,
  brighter,
  darker,
  help,
  panel,
  picture,
  record,
  truth,
  pause,
  full_screen,
  quit,
};

struct FlyInput {
  glm::dvec3 move{0.0};       // right, forward, up, each -1 .. 1: keys or sticks
  double roll = 0.0;          // -1 .. 1, the right side down
  glm::dvec2 look_px{0.0};    // mouse, right and down, while looking
  glm::dvec2 look_rate{0.0};  // stick, right and down, -1 .. 1
  glm::dvec2 sun_px{0.0};     // mouse, right and down, while it drags the sun
  double wheel = 0.0;         // notches up
  bool faster = false, slower = false;
  std::vector<Action> actions;
  std::vector<std::size_t> views;  // places in the scene's list, from 0
};

}  // namespace nephele::fly
