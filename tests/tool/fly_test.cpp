// nephele fly as a person meets it: a window of an X server, keys, scripts, what it leaves behind.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "engine/image_io.h"
#include "tests/support/support.h"
#include "tests/tool/program.h"

extern char** environ;

using namespace nephele;
using namespace nephele::test;
using nlohmann::json;

namespace {

// An X server without a screen, for as long as this lives.
class XServer {
 public:
  XServer() {
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    const std::string number = std::to_string(ends[1]);
    // -noreset: it does not start anew after its last client, when it might refuse the next.
    const char* argv[] = {"Xvfb", "-displayfd", number.c_str(), "-noreset", "-screen", "0", "1280x1024x24", nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    REQUIRE_MESSAGE(::posix_spawnp(&child_, argv[0], &actions, nullptr, const_cast<char**>(argv), environ) == 0,
                    "Xvfb, of Debian's package xvfb, does not start");
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    // To the end of the line, which the server writes apart from the number: a pipe closed before that would end it.
    for (char letter = 0; letter != '\n';) {
      REQUIRE_MESSAGE(::read(ends[0], &letter, 1) == 1, "Xvfb ended at once");
      if (letter != '\n') display_.push_back(letter);
    }
    ::close(ends[0]);
  }
  ~XServer() {
    ::kill(child_, SIGTERM);
    ::waitpid(child_, nullptr, 0);
  }
  std::map<std::string, std::string> environment() const { return {{"DISPLAY", display_}}; }
  const std::string& display() const { return display_; }

 private:
  pid_t child_ = 0;
  std::string display_{":"};
};

const XServer& x_server() {
  static const XServer server;
  return server;
}

// Small enough for a test, with everything that a frame may have.
const std::vector<std::string> kSmall{"--size", "160x96",     "--quality", "low", "--ring-size-cells",
                                      "40",     "--frame-ms", "0"};

ProgramResult fly(const TempDirectory& directory, const json& script, std::vector<std::string> more = {}) {
  write_file(directory / "script.json", script.dump());
  std::vector<std::string> arguments{"fly",          "--script", directory / "script.json", "--tables",
                                     small_tables(), "--out",    directory.path().string()};
  arguments.insert(arguments.end(), kSmall.begin(), kSmall.end());
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments, x_server().environment());
}

// What render draws of a scene that fly saved.
ProgramResult render_small(const std::string& scene, const std::string& out, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments{"render", "--scene", scene, "--tables", small_tables(), "--out", out, "--quiet"};
  arguments.insert(arguments.end(), kSmall.begin(), kSmall.end() - 2);
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

void check_same_pixels(const std::string& a, const std::string& b) {
  const auto first = read_exr(a), second = read_exr(b);
  REQUIRE(first);
  REQUIRE(second);
  CHECK(first->width == second->width);
  CHECK(first->data == second->data);
}

int system_status(const std::string& command) { return std::system(command.c_str()); }

}  // namespace

TEST_CASE("fly: after moves, edits and a new size the picture is what render draws of the saved scene, bit for bit") {
  const TempDirectory directory;
  const ProgramResult result =
      fly(directory,
          {{"frame_s", 0.05},
           {"steps",
            {{{"actions", {"pause", "panel"}}, {"frames", 3}, {"move", {0.2, 1, 0.1}}, {"look_px", {30, -5}}},
             {{"scene", {{"clouds.coverage", 0.6}, {"sun.elevation_deg", 20}}}, {"settings", {{"light_sweeps", 8}}}},
             {{"size", {200, 120}}, {"frames", 3}},
             {{"window", "minimise"}, {"frames", 2}},
             {{"window", "restore"}, {"sun_px", {40, 5}}, {"frames", 2}},
             {{"picture", directory / "shown.exr"}, {"save", directory / "scene.json"}}}}},
          {"--stats", directory / "stats.json"});
  CHECK(result.err == "");
  REQUIRE_MESSAGE(result.status == 0, result.err);
  const ProgramResult rendered = render_small(directory / "scene.json", directory / "drawn.exr",
                                              {"--size", "200x120", "--light-sweeps", "8", "--time", "0"});
  REQUIRE_MESSAGE(rendered.status == 0, rendered.err);
  check_same_pixels(directory / "shown.exr", directory / "drawn.exr");
  const json stats = json::parse(read_file(directory / "stats.json"));
  CHECK(stats["frames"].get<int>() >= 10);
  CHECK(stats["frame_ms"]["median"].get<double>() > 0);
}

TEST_CASE("fly: a recorded flight, rendered from its path, gives the frames that were shown, bit for bit") {
  const TempDirectory directory;
  json steps = {{{"actions", {"record"}}, {"move", {0, 1, 0}}, {"look_px", {20, 3}}, {"picture", directory / "0.exr"}},
                {{"frames", 3}, {"move", {0.5, 1, 0}}, {"roll", 0.5}},
                {{"picture", directory / "4.exr"}, {"look_rate", {1, 0.2}}},
                {{"actions", {"record"}}}};
  const ProgramResult flown = fly(directory, {{"steps", steps}}, {"--time", "12.5"});
  CHECK(flown.err == "");
  REQUIRE_MESSAGE(flown.status == 0, flown.err);
  CHECK(flown.out.find("nephele render --scene") == 0);
  CHECK(flown.out.find(" --time 12.5 ") != std::string::npos);
  CHECK(flown.out.find(" --path '") != std::string::npos);
  const ProgramResult rendered = render_small(directory / "flight_0001_scene.json", directory / "f%02d.exr",
                                              {"--time", "12.5", "--path", directory / "flight_0001.json"});
  REQUIRE_MESSAGE(rendered.status == 0, rendered.err);
  check_same_pixels(directory / "0.exr", directory / "f00.exr");
  check_same_pixels(directory / "4.exr", directory / "f04.exr");
}

TEST_CASE("fly: real keys reach it, the window bears the program's name, Escape ends it with status 0") {
  const TempDirectory directory;
  std::thread keys([&] {
    const std::string tool = "DISPLAY=" + x_server().display() + " timeout 60 xdotool ";
    // Waits for the window, then types into it, since without a window manager nothing gives it the focus.
    system_status(tool + "search --sync --name '^Nephele' windowfocus --sync > /dev/null 2>&1");
    for (int i = 0; i < 600; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      system_status(tool + "key p > /dev/null 2>&1");
      if (directory.entries().size() >= 2) break;
    }
    system_status(tool + "key F1 keydown w > /dev/null 2>&1");
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    system_status(tool + "keyup w key Escape > /dev/null 2>&1");
  });
  std::vector<std::string> arguments{"fly", "--tables", small_tables(), "--out", directory.path().string()};
  arguments.insert(arguments.end(), kSmall.begin(), kSmall.end());
  const ProgramResult result = run_program(arguments, x_server().environment());
  keys.join();
  CHECK(result.err == "");
  CHECK(result.status == 0);
  const std::vector<std::string> left = directory.entries();
  REQUIRE(left.size() >= 2);
  CHECK(left[0] == "picture_0001.exr");
  CHECK(left[1] == "picture_0001.png");
  CHECK(read_exr(directory / "picture_0001.exr"));
}

TEST_CASE("fly: bad input is one line, and no window system is one too") {
  const TempDirectory directory;
  write_file(directory / "bad.json", R"({"steps": [{"frames": -1}]})");
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& part,
                           const std::map<std::string, std::string>& environment) {
    const ProgramResult result = run_program(arguments, environment);
    CHECK(result.status == 2);
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK_MESSAGE(result.err.find(part) != std::string::npos, result.err);
  };
  refused({"fly", "--script", directory / "bad.json"}, "steps[0].frames", x_server().environment());
  refused({"fly", "--scene", directory / "none.json"}, "none.json", x_server().environment());
  refused({"fly", "--frame-ms", "-1"}, "--frame-ms", x_server().environment());
  refused({"fly", "--out", directory / "none"}, "no directory", x_server().environment());
  refused({"fly", "--stats", directory / "a.txt"}, ".json", x_server().environment());
  refused({"fly", "--device", "none of these"}, "none of these", x_server().environment());
  refused({"fly"}, "no window", {{"DISPLAY", ":9999"}, {"WAYLAND_DISPLAY", ""}});
}

TEST_CASE("fly: random input, sizes, settings and scenes leave the picture that a new program draws") {
  const TempDirectory directory;
  std::mt19937 random(11);
  const auto pick = [&](int below) { return static_cast<int>(random() % static_cast<unsigned>(below)); };
  const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  json steps = {{{"actions", {"pause", "panel"}}}};
  for (int i = 0; i < 16; ++i) {
    json step = {{"frames", 1 + pick(3)},
                 {"move", {unit(), unit(), unit()}},
                 {"look_px", {40 * unit(), 20 * unit()}},
                 {"wheel", pick(3) - 1},
                 {"roll", unit()}};
    switch (pick(10)) {
      case 0:
        step["size"] = {96 + 8 * pick(10), 64 + 8 * pick(8)};
        break;
      case 1:
        step["settings"] = {{"quality", "low"}, {"ring_size_cells", 40 + 8 * pick(2)}};
        break;
      case 2:
        step["settings"] = {{"scale", 1 << pick(3)}, {"detail", pick(2) == 1}};
        break;
      case 3:
        step["settings"] = {{"blend", pick(2) ? "exact" : "volume"}, {"backend", "tiled"}};
        break;
      case 4:
        step["scene"] = {{"clouds.coverage", 0.5 + 0.5 * unit()}, {"clouds.seed", pick(100)}};
        break;
      case 5:
        step["scene"] = {{"atmosphere.enabled", pick(2) == 1}, {"sun.elevation_deg", 40 * unit()}};
        break;
      case 6:
        step["scene"] = {{"clouds.base_m", 1500 + 1000 * unit()}, {"exposure_ev", 2 * unit()}};
        break;
      case 7:
        step["window"] = pick(2) ? "minimise" : "restore";
        break;
      case 8:
        step["actions"] = {pick(2) ? "panel" : "help"};
        break;
      default:
        step["sun_px"] = {100 * unit(), 20 * unit()};
    }
    steps.push_back(step);
  }
  steps.push_back({{"size", {160, 96}},
                   {"window", "restore"},
                   {"frames", 4},
                   {"settings",
                    {{"quality", "low"},
                     {"ring_size_cells", 40},
                     {"scale", 2},
                     {"detail", true},
                     {"blend", "volume"},
                     {"backend", "auto"}}}});
  steps.push_back({{"frames", 40}});  // until the camera rests
  steps.push_back({{"picture", directory / "shown.exr"}, {"save", directory / "scene.json"}});
  const ProgramResult flown = fly(directory, {{"frame_s", 0.05}, {"steps", steps}}, {"--stats", directory / "s.json"});
  CHECK(flown.err == "");
  REQUIRE_MESSAGE(flown.status == 0, flown.err);
  const ProgramResult rendered =
      render_small(directory / "scene.json", directory / "drawn.exr", {"--scale", "2", "--time", "0"});
  REQUIRE_MESSAGE(rendered.status == 0, rendered.err);
  check_same_pixels(directory / "shown.exr", directory / "drawn.exr");
}
