// The program as a user runs it: help, devices, bake and small renders.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/image_io.h"
#include "tests/support/support.h"
#include "tests/tool/program.h"

using namespace nephele;
using namespace nephele::test;

namespace {

// Must succeed, and say nothing on stderr.
ProgramResult run_quietly(const std::vector<std::string>& arguments,
                          const std::map<std::string, std::string>& environment = {}) {
  ProgramResult result = run_program(arguments, environment);
  CAPTURE(arguments);
  CHECK_MESSAGE(result.status == 0, result.err);
  CHECK(result.err.empty());
  return result;
}

// Compared out of doctest's sight, which would print them.
bool same_bytes(const std::string& path_a, const std::string& path_b) { return read_file(path_a) == read_file(path_b); }

std::uintmax_t bytes_under(const std::string& directory) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

std::vector<std::string> small_render(std::vector<std::string> more) {
  std::vector<std::string> arguments{"render", "--size", "64x36", "--quality", "low", "--tables", small_tables()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace

TEST_CASE("program: help and version go to stdout") {
  CHECK(run_quietly({"--version"}).out == "nephele 0.1.0\n");
  const std::string help = run_quietly({"--help"}).out;
  for (const char* command : {"render", "bake", "probe", "reference", "compare", "devices"}) {
    CHECK(help.find(command) != std::string::npos);
    CHECK(run_quietly({command, "--help"}).out.find("Usage: nephele " + std::string(command)) != std::string::npos);
  }
}

TEST_CASE("program: devices names a device and its backend") {
  const std::string out = run_quietly({"devices"}).out;
  CHECK(out.starts_with("0  "));
  CHECK(out.find("backend: ") != std::string::npos);
}

// Lavapipe puts uniform data into code that branches on it, and then compiles the shader for every frame that has other
// data: what it compiles grows its cache on disk. (Coverage sets capacities, which choose kernels: here it is the
// same.)
TEST_CASE("program: no shader is compiled anew for another camera, sun and weather") {
  const TempDirectory directory;
  const std::string cache = directory / "cache";
  std::filesystem::create_directory(cache);
  const std::map<std::string, std::string> environment{{"MESA_SHADER_CACHE_DIR", cache},
                                                       {"MESA_SHADER_CACHE_DISABLE", "false"}};
  write_file(directory / "a.json",
             R"({"camera": {"position_m": [0, 0, 300], "yaw_deg": 10, "pitch_deg": 5},
          "sun": {"azimuth_deg": 200, "elevation_deg": 30}})");
  write_file(
      directory / "b.json",
      R"({"camera": {"position_m": [70000, 5000, 9000], "yaw_deg": 250, "pitch_deg": -35, "vertical_fov_deg": 40},
      "sun": {"azimuth_deg": 20, "elevation_deg": 4, "irradiance": [1.1, 1.2, 1.3]},
      "clouds": {"seed": 9, "base_m": 900, "thickness_m": 2500, "extinction_per_m": 0.03, "wind_m_per_s": [7, -4]}})");
  const auto compiled = [&](const std::string& scene, const std::vector<std::string>& more) {
    std::vector<std::string> arguments =
        small_render({"--scene", directory / scene, "--out", directory / "out%02d.png", "--frames", "2"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    run_quietly(arguments, environment);
    return bytes_under(cache);
  };
  const bool lavapipe = run_quietly({"devices"}).out.find("llvmpipe") != std::string::npos;
  for (const std::vector<std::string>& mode : {std::vector<std::string>{"--scale", "2"},
                                               {"--blend", "exact"},
                                               {"--backend", "attachment"},
                                               {"--method", "raymarch", "--steps", "8"}}) {
    CAPTURE(mode);
    // Mesa keeps a few small kernels on disk only when a second or third process asks for them.
    compiled("a.json", mode);
    compiled("a.json", mode);
    const std::uintmax_t once = compiled("a.json", mode);
    if (lavapipe) CHECK(once > 100000);
    CHECK(compiled("b.json", mode) == once);
  }
}

TEST_CASE("program: bake writes three tables, the same bytes every time") {
  const TempDirectory directory;
  const std::vector<std::string> files{"multiple_scattering.json", "multiple_scattering.npy",
                                       "near_beam.json",           "near_beam.npy",
                                       "optical_depth.json",       "optical_depth.npy"};
  const std::vector<std::string> bake{"bake",  "--preset",   "fast", "--size-optical-depth", "4", "--size-scattering",
                                      "4x3x4", "--residual", "0.01"};
  auto with_stats = bake;
  with_stats.insert(with_stats.end(), {"--out", directory / "a", "--stats", directory / "stats.json"});
  run_quietly(with_stats);
  bake_small_tables(directory / "b");
  CHECK(directory.entries() == std::vector<std::string>{"a", "b", "stats.json"});
  for (const std::string& file : files) CHECK(same_bytes(directory / ("a/" + file), directory / ("b/" + file)));
  const auto stats = nlohmann::json::parse(read_file(directory / "stats.json"));
  REQUIRE(stats.at("tables").size() == 3);
  CHECK(stats["tables"][0].at("name") == "optical_depth");
  CHECK(stats["tables"][0].at("shape") == nlohmann::json{16, 4, 4, 2});
  CHECK(stats["tables"][1].at("shape") == nlohmann::json{4, 3, 4, 4});
  CHECK(stats["tables"][2].at("name") == "near_beam");
  CHECK(stats["tables"][2].at("shape") == nlohmann::json{1, 64, 128, 1});
}

TEST_CASE("program: a damaged table in the cache is reported and baked again") {
  const TempDirectory directory;
  const std::map<std::string, std::string> environment{{"XDG_CACHE_HOME", directory.path().string()}};
  const std::vector<std::string> bake{"bake",  "--preset",   "fast", "--size-optical-depth", "4", "--size-scattering",
                                      "4x3x4", "--residual", "0.01"};
  run_quietly(bake, environment);
  std::string damaged;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "nephele"))
    if (entry.path().filename().string().starts_with("optical_depth") && entry.path().extension() == ".npy")
      damaged = entry.path().string();
  REQUIRE_FALSE(damaged.empty());
  const std::string good = read_file(damaged);
  write_file(damaged, good.substr(0, good.size() / 2));

  const ProgramResult result = run_program(bake, environment);
  CHECK(result.status == 0);
  CHECK(result.err.find("optical_depth") != std::string::npos);
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  const bool restored = read_file(damaged) == good;
  CHECK(restored);
  run_quietly(bake, environment);
}

TEST_CASE("program: a small render as PNG, EXR, layers and statistics") {
  const TempDirectory directory;
  run_quietly(small_render({"--out", directory / "a.png"}));
  run_quietly(small_render({"--out", directory / "a.exr", "--layers", directory / "layers.exr", "--stats",
                            directory / "stats.json", "--warmup", "1"}));
  CHECK(directory.entries() == std::vector<std::string>{"a.exr", "a.png", "layers.exr", "stats.json"});

  CHECK(read_file(directory / "a.png").starts_with("\x89PNG\r\n\x1a\n"));

  const Result<ImageF> image = read_exr(directory / "a.exr");
  if (!image) FAIL(image.error().message);
  CHECK(image->width == 64);
  CHECK(image->height == 36);
  CHECK(image->channels == std::vector<std::string>{"B", "G", "R"});
  CHECK(std::all_of(image->data.begin(), image->data.end(), [](float x) { return std::isfinite(x) && x >= 0; }));
  CHECK(std::any_of(image->data.begin(), image->data.end(), [](float x) { return x > 0.001f; }));

  const Result<ImageF> layers = read_exr(directory / "layers.exr");
  if (!layers) FAIL(layers.error().message);
  CHECK(layers->channels == std::vector<std::string>{"B", "G", "R", "T", "Z"});
  const std::size_t t = *layers->channel_index("T"), z = *layers->channel_index("Z");
  int cloudy = 0, transmittance_outside = 0, distance_missing = 0;
  for (std::uint32_t y = 0; y < layers->height; ++y)
    for (std::uint32_t x = 0; x < layers->width; ++x) {
      const float transmittance = layers->at(x, y, t), distance_m = layers->at(x, y, z);
      if (!(transmittance >= 0 && transmittance <= 1)) ++transmittance_outside;
      if (transmittance < 0.5f) ++cloudy;
      if (!(distance_m > 0) || (transmittance < 0.5f && !std::isfinite(distance_m))) ++distance_missing;
    }
  CHECK(cloudy > 0);
  CHECK(transmittance_outside == 0);
  CHECK(distance_missing == 0);

  const auto stats = nlohmann::json::parse(read_file(directory / "stats.json"));
  for (const char* key :
       {"device", "driver", "width", "height", "scale", "quality", "backend", "blend", "particles_generated",
        "particles_visible", "overflow", "frame_ms", "cpu_ms", "passes", "gpu_memory_bytes", "fragments_shaded"})
    CHECK_MESSAGE(stats.contains(key), key);
  CHECK(stats["width"] == 64);
  CHECK(stats["height"] == 36);
  CHECK(stats["quality"] == "low");
  CHECK(stats["backend"] != "auto");
  CHECK(stats["blend"] == "volume");
  CHECK(stats["particles_generated"] > 0);
  CHECK(stats["particles_visible"] <= stats["particles_generated"]);
  for (const auto& [buffer, lost] : stats["overflow"].items()) CHECK_MESSAGE(lost == 0, buffer);
  REQUIRE(stats.at("sources").size() == 1);
  CHECK(stats["sources"][0].at("name") == "field");
  CHECK(stats["sources"][0].at("particles_generated") == stats["particles_generated"]);
  CHECK(stats["sources"][0].at("overflow") == 0);
  CHECK(stats["frame_ms"]["min"] <= stats["frame_ms"]["median"]);
  CHECK(stats["frame_ms"]["median"] <= stats["frame_ms"]["p95"]);
  CHECK(stats["gpu_memory_bytes"] > 0);
  REQUIRE(stats["passes"].size() > 0);
  for (const auto& pass : stats["passes"]) {
    CHECK(pass.at("name").is_string());
    CHECK(pass.at("ms") >= 0);
  }
}

TEST_CASE("program: two runs write the same bytes") {
  const TempDirectory directory;
  for (const char* name : {"a", "b"})
    run_quietly(small_render({"--time", "12.5", "--out", directory / (std::string(name) + ".exr"), "--layers",
                              directory / (std::string(name) + "-layers.exr")}));
  CHECK(same_bytes(directory / "a.exr", directory / "b.exr"));
  CHECK(same_bytes(directory / "a-layers.exr", directory / "b-layers.exr"));
}

TEST_CASE("program: a sequence along a camera path is numbered and moves") {
  const TempDirectory directory;
  write_file(directory / "path.json", R"({"fps": 2, "keys": [
      {"time_s": 0, "position_m": [0, 0, 1000]}, {"time_s": 1, "position_m": [0, 500, 1500], "yaw_deg": 90}]})");
  run_quietly(small_render({"--path", directory / "path.json", "--out", directory / "f%04d.png"}));
  CHECK(directory.entries() == std::vector<std::string>{"f0000.png", "f0001.png", "f0002.png", "path.json"});
  CHECK_FALSE(same_bytes(directory / "f0000.png", directory / "f0002.png"));
  // A frame of the path is what a single render there gives: no frame depends on those before it.
  write_file(directory / "scene.json", R"({"camera": {"position_m": [0, 500, 1500], "yaw_deg": 90, "pitch_deg": 0}})");
  run_quietly(small_render({"--scene", directory / "scene.json", "--time", "1", "--out", directory / "one.png"}));
  CHECK(same_bytes(directory / "f0002.png", directory / "one.png"));
}

TEST_CASE("program: reuse changes no byte of any frame") {
  const TempDirectory directory;
  const std::string path = directory / "path.json";
  write_file(
      path, R"({"fps": 2, "keys": [{"time_s": 0, "position_m": [0, 0, 1200]}, {"time_s": 1, "position_m": [0, 0, 1200]},
                                          {"time_s": 2, "position_m": [40, 0, 1200], "yaw_deg": 5}]})");
  run_quietly(small_render({"--path", path, "--out", directory / "a%04d.png"}));
  run_quietly(small_render({"--path", path, "--out", directory / "b%04d.png", "--reuse"}));
  for (const char* frame : {"0000.png", "0001.png", "0002.png", "0003.png", "0004.png"})
    CHECK_MESSAGE(
        read_file(directory / (std::string("a") + frame)) == read_file(directory / (std::string("b") + frame)), frame);
}

TEST_CASE("program: an option given twice means its last value, so scripts can give defaults") {
  const TempDirectory directory;
  run_quietly(small_render({"--size", "32x18", "--out", directory / "a.exr", "--out", directory / "b.exr"}));
  CHECK(directory.entries() == std::vector<std::string>{"b.exr"});
  const Result<ImageF> image = read_exr(directory / "b.exr");
  if (!image) FAIL(image.error().message);
  CHECK(image->width == 32);
}

TEST_CASE("program: a view, by its name or number, is the picture of a scene whose camera is the view's") {
  const TempDirectory directory;
  const std::string camera = R"({"position_m": [10, 20, 900], "yaw_deg": 75, "pitch_deg": 12, "vertical_fov_deg": 70})";
  const std::string sky = R"("clouds": {"seed": 2}})";
  // The second view is called like the number of the first: names go before numbers.
  write_file(directory / "views.json", R"({"camera": {"yaw_deg": 200}, "views": [{"name": "east", "camera": )" +
                                           camera + R"(}, {"name": "1"}], )" + sky);
  write_file(directory / "east.json", R"({"camera": )" + camera + ", " + sky);
  write_file(directory / "default.json", "{" + sky);
  const auto picture = [&](const std::string& scene, const std::vector<std::string>& view) {
    std::vector<std::string> arguments = small_render({"--scene", directory / scene, "--out", directory / "x.exr"});
    arguments.insert(arguments.end(), view.begin(), view.end());
    run_quietly(arguments);
    return read_file(directory / "x.exr");
  };
  const std::string east = picture("east.json", {}), by_default = picture("default.json", {});
  const bool named = picture("views.json", {"--view", "east"}) == east;
  CHECK(named);
  const bool name_first = picture("views.json", {"--view", "1"}) == by_default;
  CHECK(name_first);
  const bool numbered = picture("views.json", {"--view", "2"}) == by_default;
  CHECK(numbered);
  const std::string own = picture("views.json", {});
  const bool own_differs = own != east && own != by_default;
  CHECK(own_differs);

  const auto traced = [&](const std::string& scene, const std::vector<std::string>& view) {
    std::vector<std::string> arguments{"reference", "--quiet",      "--scene", directory / scene,
                                       "--size",    "8x6",          "--spp",   "1",
                                       "--tables",  small_tables(), "--out",   directory / "x.exr"};
    arguments.insert(arguments.end(), view.begin(), view.end());
    run_quietly(arguments);
    return read_file(directory / "x.exr");
  };
  const bool traced_alike = traced("views.json", {"--view", "east"}) == traced("east.json", {});
  CHECK(traced_alike);
}

TEST_CASE("program: a scene without clouds renders the sky alone") {
  const TempDirectory directory;
  write_file(directory / "scene.json", R"({"particles": []})");
  run_quietly(small_render({"--scene", directory / "scene.json", "--layers", directory / "layers.exr", "--stats",
                            directory / "stats.json"}));
  const Result<ImageF> layers = read_exr(directory / "layers.exr");
  if (!layers) FAIL(layers.error().message);
  const std::size_t t = *layers->channel_index("T"), z = *layers->channel_index("Z");
  CHECK(layers->at(7, 7, t) == 1.0f);
  CHECK(std::isinf(layers->at(7, 7, z)));
  CHECK(nlohmann::json::parse(read_file(directory / "stats.json")).at("particles_generated") == 0);
}

TEST_CASE("program: compare prints the metrics of the channels that were asked for") {
  const TempDirectory directory;
  REQUIRE(write_exr(directory / "test.exr", {2, 1, {"R", "G", "B", "T"}, {1, 1, 1, 0.5f, 1, 1, 2, 0.25f}}));
  REQUIRE(write_exr(directory / "truth.exr", {2, 1, {"R", "G", "B", "T"}, {1, 1, 1, 0.25f, 1, 1, 1, 0.25f}}));
  const auto compare = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"compare", directory / "test.exr", directory / "truth.exr"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return nlohmann::json::parse(run_quietly(arguments).out);
  };
  const auto colour = compare({});
  std::vector<std::string> keys;
  for (const auto& [key, value] : colour.items()) keys.push_back(key);
  CHECK(keys == std::vector<std::string>{"bias", "max_abs", "p99_abs", "pixels", "psnr_db", "relmse", "rmse"});
  CHECK(colour["rmse"].get<double>() == doctest::Approx(std::sqrt(1.0 / 6)));  // one of six values is off by one
  CHECK(colour["bias"].get<double>() == doctest::Approx(1.0 / 6));
  CHECK(colour["pixels"] == 2);
  const auto transmittance = compare({"--channels", "T"});
  CHECK(transmittance["bias"].get<double>() == doctest::Approx(0.5));
  CHECK(transmittance["max_abs"] == 0.25);
  const auto two = compare({"--channels", "R,G"});
  CHECK(two["rmse"] == 0.0);
  CHECK(two["psnr_db"].is_null());  // infinite
}

TEST_CASE("program: a reference in two goes is the same as in one, and looks like the render") {
  const TempDirectory directory;
  write_file(directory / "scene.json", R"({"camera": {"position_m": [0, 0, 1000], "pitch_deg": 0},
      "particles": [{"center_m": [0, 600, 1000], "radius_m": [150, 150, 100], "shape": "homogeneous"}]})");
  const auto reference = [&](const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> arguments{
        "reference", "--scene", directory / "scene.json",   "--size", "24x16", "--tables", small_tables(),
        "--quiet",   "--out",   directory / (name + ".exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    run_quietly(arguments);
  };
  reference("one", {"--spp", "40", "--layers", directory / "layers.exr", "--threads", "1"});
  reference("two", {"--spp", "24", "--resume"});
  reference("two", {"--spp", "40", "--resume", "--threads", "3", "--picture", directory / "two.png"});
  CHECK(directory.entries() ==
        std::vector<std::string>{"layers.exr", "one.exr", "scene.json", "two.exr", "two.exr.state", "two.png"});
  CHECK(same_bytes(directory / "one.exr", directory / "two.exr"));
  CHECK(read_file(directory / "two.png").starts_with("\x89PNG\r\n\x1a\n"));

  const Result<ImageF> image = read_exr(directory / "one.exr"), layers = read_exr(directory / "layers.exr");
  REQUIRE(image);
  REQUIRE(layers);
  CHECK(image->channels == std::vector<std::string>{"B", "G", "R", "SE", "T"});
  CHECK(layers->channels == std::vector<std::string>{"B", "G", "R", "T", "Z"});

  // The renderer draws the same particle at the same place.
  run_quietly({"render", "--scene", directory / "scene.json", "--size", "24x16", "--tables", small_tables(), "--layers",
               directory / "rendered.exr"});
  const auto compared =
      run_quietly({"compare", directory / "rendered.exr", directory / "layers.exr", "--channels", "T"});
  // Pixels of the outline are covered in part in the reference, wholly or not at all by the render's one sample: 0.07.
  // A particle one pixel off would be 0.2 and more.
  CHECK(nlohmann::json::parse(compared.out)["rmse"].get<double>() < 0.12);
}

TEST_CASE("program: a reference goes on until its noise is as low as asked") {
  const TempDirectory directory;
  write_file(directory / "scene.json", R"({"particles": [{"center_m": [0, 600, 1500], "shape": "homogeneous"}]})");
  const ProgramResult result =
      run_program({"reference", "--scene", directory / "scene.json", "--size", "16x9", "--tables", small_tables(),
                   "--out", directory / "a.exr", "--noise", "0.02"});
  CHECK(result.status == 0);
  CHECK(result.err.find("samples a pixel, mean relative standard error") != std::string::npos);
  const Result<ImageF> image = read_exr(directory / "a.exr");
  REQUIRE(image);
  double sum = 0;
  for (std::uint32_t y = 0; y < 9; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) {
      const double luminance = 0.2126 * image->at(x, y, *image->channel_index("R")) +
                               0.7152 * image->at(x, y, *image->channel_index("G")) +
                               0.0722 * image->at(x, y, *image->channel_index("B"));
      sum += image->at(x, y, *image->channel_index("SE")) / luminance / (16 * 9);
    }
  CHECK(sum <= 0.02001);  // floats
  CHECK(sum > 0.002);
}
