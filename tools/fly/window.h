// The window and what people do in it, as FlyInput. Dear ImGui sees every event first; what it takes flies nothing.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>

#include "engine/result.h"
#include "tools/fly/fly_input.h"

struct GLFWwindow;

namespace nephele::fly {

class Window {
 public:
  // width, height: of its picture in pixels, where the screen allows it.
  static Result<std::unique_ptr<Window>> create(std::uint32_t width, std::uint32_t height, const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // What happened since the last call. wait: at most this long for something to happen, where nothing is to be drawn.
  FlyInput poll(double wait_s = 0.0);
  bool closed() const;
  glm::uvec2 framebuffer_px() const;  // 0 while minimised
  float content_scale() const;        // of the monitor that the window is on, 1 at 96 dpi
  void set_title(const std::string& title);
  void resize(std::uint32_t width, std::uint32_t height);
  void minimise();
  void restore();
  void toggle_full_screen();  // on the monitor that has most of the window
  void copy_text(const std::string& text);
  GLFWwindow* glfw() const { return window_; }

 private:
  explicit Window(GLFWwindow* window);
  struct Events;
  static Events& events_of(GLFWwindow* window);
  void read_keys(FlyInput& input) const;
  void read_gamepad(FlyInput& input);

  GLFWwindow* window_;
  std::unique_ptr<Events> events_;
  glm::ivec4 windowed_{0};  // place and size before full screen
};

// The names of the keys and what they do, a line each.
const char* key_help();

}  // namespace nephele::fly
