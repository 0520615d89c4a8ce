#include "tools/fly/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/check.h"

namespace nephele::fly {
namespace {

constexpr double kDeadZone = 0.12;  // of a stick

struct KeyAction {
  int key;
  Action action;
};
constexpr KeyAction kKeyActions[] = {
    {GLFW_KEY_L, Action::level_out},     {GLFW_KEY_EQUAL, Action::brighter},     {GLFW_KEY_KP_ADD, Action::brighter},
    {GLFW_KEY_MINUS, Action::darker},    {GLFW_KEY_KP_SUBTRACT, Action::darker}, {GLFW_KEY_H, Action::help},
    {GLFW_KEY_F1, Action::panel},        {GLFW_KEY_P, Action::picture},          {GLFW_KEY_R, Action::record},
    {GLFW_KEY_T, Action::truth},         {GLFW_KEY_PAUSE, Action::pause},        {GLFW_KEY_B, Action::pause},
    {GLFW_KEY_F11, Action::full_screen}, {GLFW_KEY_ESCAPE, Action::quit},
};

// A stick's axis without the play about its middle.
double deflection(float axis) {
  const double size = std::abs(static_cast<double>(axis));
  return size < kDeadZone ? 0.0 : std::copysign((size - kDeadZone) / (1.0 - kDeadZone), static_cast<double>(axis));
}

bool imgui_has_keys() { return ImGui::GetCurrentContext() && ImGui::GetIO().WantCaptureKeyboard; }
bool imgui_has_mouse() { return ImGui::GetCurrentContext() && ImGui::GetIO().WantCaptureMouse; }

std::string last_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

}  // namespace

// Filled by the callbacks, emptied by poll.
struct Window::Events {
  FlyInput input;
  glm::dvec2 cursor_px{0.0};
  bool has_cursor = false;
  bool looking = false;       // with the right button
  bool dragging_sun = false;  // with Ctrl and the left button
  GLFWgamepadstate pad{};     // as last polled
};

const char* key_help() {
  return "W A S D      forward, left, back, right\n"
         "Space, C     up, down (also E, Q)\n"
         "right mouse  look while held\n"
         "wheel        speed, from walking to orbital\n"
         "Shift, Ctrl  five times as fast, as slow\n"
         "Z, X         roll left, right\n"
         "L            level out\n"
         "Ctrl + drag  move the sun\n"
         "1 ... 9      the scene's views\n"
         "+ -          exposure\n"
         "B            hold or release the clock\n"
         "P            picture (PNG and EXR)\n"
         "R            record a flight\n"
         "T            path-traced truth of this view\n"
         "F1           panel\n"
         "F11          full screen\n"
         "H            this help\n"
         "Esc          end\n";
}

Result<std::unique_ptr<Window>> Window::create(std::uint32_t width, std::uint32_t height, const std::string& title) {
  if (!glfwInit()) return Error{"no window system was found (" + last_error() + "); nephele render needs none"};
  if (!glfwVulkanSupported()) {
    const std::string reason = last_error();
    glfwTerminate();
    return Error{"this window system can't present what Vulkan draws (" + reason + ")"};
  }
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  GLFWwindow* window =
      glfwCreateWindow(static_cast<int>(width), static_cast<int>(height), title.c_str(), nullptr, nullptr);
  if (!window) {
    const std::string reason = last_error();
    glfwTerminate();
    return Error{"no window could be opened (" + reason + ")"};
  }
  return std::unique_ptr<Window>(new Window(window));
}

Window::Window(GLFWwindow* window) : window_(window), events_(std::make_unique<Events>()) {
  glfwSetWindowUserPointer(window, this);
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int what, int) {
    if (what != GLFW_PRESS || (imgui_has_keys() && key != GLFW_KEY_F1 && key != GLFW_KEY_ESCAPE)) return;
    Events& e = events_of(w);
    for (const KeyAction& entry : kKeyActions)
      if (entry.key == key) e.input.actions.push_back(entry.action);
    if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9) e.input.views.push_back(static_cast<std::size_t>(key - GLFW_KEY_1));
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double notches) {
    if (!imgui_has_mouse()) events_of(w).input.wheel += notches;
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int what, int modifiers) {
    Events& e = events_of(w);
    const bool press = what == GLFW_PRESS && !imgui_has_mouse();
    if (button == GLFW_MOUSE_BUTTON_RIGHT) {
      e.looking = press;
      glfwSetInputMode(w, GLFW_CURSOR, press ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
      e.has_cursor = false;
    }
    if (button == GLFW_MOUSE_BUTTON_LEFT) e.dragging_sun = press && (modifiers & GLFW_MOD_CONTROL);
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    Events& e = events_of(w);
    const glm::dvec2 moved = e.has_cursor ? glm::dvec2(x, y) - e.cursor_px : glm::dvec2(0.0);
    e.cursor_px = {x, y};
    e.has_cursor = true;
    if (e.looking) e.input.look_px += moved;
    if (e.dragging_sun) e.input.sun_px += moved;
  });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int focused) {
    Events& e = events_of(w);
    if (focused) return;
    e.looking = e.dragging_sun = false;
    glfwSetInputMode(w, GLFW_CURSOR, GLFW_CURSOR_NORMAL);
  });
}

Window::Events& Window::events_of(GLFWwindow* window) {
  return *static_cast<Window*>(glfwGetWindowUserPointer(window))->events_;
}

Window::~Window() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

FlyInput Window::poll(double wait_s) {
  if (wait_s > 0.0)
    glfwWaitEventsTimeout(wait_s);
  else
    glfwPollEvents();
  FlyInput input = std::exchange(events_->input, {});
  if (!imgui_has_keys()) read_keys(input);
  read_gamepad(input);
  return input;
}

void Window::read_keys(FlyInput& input) const {
  const auto held = [this](int key) { return glfwGetKey(window_, key) == GLFW_PRESS; };
  const auto axis = [&](bool positive, bool negative) { return (positive ? 1.0 : 0.0) - (negative ? 1.0 : 0.0); };
  const bool control = held(GLFW_KEY_LEFT_CONTROL) || held(GLFW_KEY_RIGHT_CONTROL);
  input.move.x += axis(held(GLFW_KEY_D), held(GLFW_KEY_A));
  input.move.y += axis(held(GLFW_KEY_W), held(GLFW_KEY_S));
  input.move.z += axis(held(GLFW_KEY_SPACE) || held(GLFW_KEY_E), held(GLFW_KEY_C) || held(GLFW_KEY_Q));
  input.roll += axis(held(GLFW_KEY_X), held(GLFW_KEY_Z));
  input.faster |= held(GLFW_KEY_LEFT_SHIFT) || held(GLFW_KEY_RIGHT_SHIFT);
  input.slower |= held(GLFW_KEY_LEFT_ALT) || (control && !events_->dragging_sun);
}

void Window::read_gamepad(FlyInput& input) {
  GLFWgamepadstate pad{};
  int found = -1;
  for (int i = GLFW_JOYSTICK_1; i <= GLFW_JOYSTICK_LAST && found < 0; ++i)
    if (glfwJoystickIsGamepad(i) && glfwGetGamepadState(i, &pad)) found = i;
  if (found < 0) return;
  const auto axis = [&](int i) { return deflection(pad.axes[i]); };
  const auto trigger = [&](int i) { return 0.5 * (1.0 + static_cast<double>(pad.axes[i])); };
  input.move.x += axis(GLFW_GAMEPAD_AXIS_LEFT_X);
  input.move.y -= axis(GLFW_GAMEPAD_AXIS_LEFT_Y);
  input.move.z += trigger(GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER) - trigger(GLFW_GAMEPAD_AXIS_LEFT_TRIGGER);
  input.look_rate += glm::dvec2(axis(GLFW_GAMEPAD_AXIS_RIGHT_X), axis(GLFW_GAMEPAD_AXIS_RIGHT_Y));
  const auto held = [&](int button) { return pad.buttons[button] == GLFW_PRESS; };
  input.roll +=
      (held(GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER) ? 1.0 : 0.0) - (held(GLFW_GAMEPAD_BUTTON_LEFT_BUMPER) ? 1.0 : 0.0);
  input.faster |= held(GLFW_GAMEPAD_BUTTON_LEFT_THUMB);
  input.slower |= held(GLFW_GAMEPAD_BUTTON_RIGHT_THUMB);
  const auto pressed = [&](int button) { return held(button) && events_->pad.buttons[button] != GLFW_PRESS; };
  if (pressed(GLFW_GAMEPAD_BUTTON_DPAD_UP)) input.wheel += 1.0;
  if (pressed(GLFW_GAMEPAD_BUTTON_DPAD_DOWN)) input.wheel -= 1.0;
  if (pressed(GLFW_GAMEPAD_BUTTON_A)) input.actions.push_back(Action::level_out);
  if (pressed(GLFW_GAMEPAD_BUTTON_X)) input.actions.push_back(Action::picture);
  if (pressed(GLFW_GAMEPAD_BUTTON_START)) input.actions.push_back(Action::panel);
  events_->pad = pad;
}

bool Window::closed() const { return glfwWindowShouldClose(window_); }

glm::uvec2 Window::framebuffer_px() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return glm::uvec2(0);
  return {std::max(0, width), std::max(0, height)};
}

float Window::content_scale() const {
  float x = 1.0f, y = 1.0f;
  glfwGetWindowContentScale(window_, &x, &y);
  return std::max(1.0f, std::max(x, y));
}

void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }
void Window::resize(std::uint32_t width, std::uint32_t height) {
  glfwSetWindowSize(window_, static_cast<int>(width), static_cast<int>(height));
}
void Window::minimise() { glfwIconifyWindow(window_); }
void Window::restore() { glfwRestoreWindow(window_); }
void Window::copy_text(const std::string& text) { glfwSetClipboardString(window_, text.c_str()); }

void Window::toggle_full_screen() {
  if (glfwGetWindowMonitor(window_)) {
    glfwSetWindowMonitor(window_, nullptr, windowed_.x, windowed_.y, windowed_.z, windowed_.w, GLFW_DONT_CARE);
    return;
  }
  glfwGetWindowPos(window_, &windowed_.x, &windowed_.y);
  glfwGetWindowSize(window_, &windowed_.z, &windowed_.w);
  int count = 0;
  GLFWmonitor** monitors = glfwGetMonitors(&count);
  GLFWmonitor* best = nullptr;
  int best_area = -1;
  for (int i = 0; i < count; ++i) {
    int x = 0, y = 0;
    glfwGetMonitorPos(monitors[i], &x, &y);
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    if (!mode) continue;
    const int across = std::max(0, std::min(windowed_.x + windowed_.z, x + mode->width) - std::max(windowed_.x, x));
    const int down = std::max(0, std::min(windowed_.y + windowed_.w, y + mode->height) - std::max(windowed_.y, y));
    if (across * down <= best_area) continue;
    best = monitors[i];
    best_area = across * down;
  }
  if (!best) return;
  const GLFWvidmode* mode = glfwGetVideoMode(best);
  glfwSetWindowMonitor(window_, best, 0, 0, mode->width, mode->height, mode->refreshRate);
}

}  // namespace nephele::fly
