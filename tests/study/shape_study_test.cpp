// Not part of the suite: shapes of clouds in figures that are known of nature, and where their light lies; tables in
// docs/shape.md.
//   test_study --no-skip --test-case="shape study"
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "engine/image_io.h"
#include "passes/nephele.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr std::uint32_t kSide = 1024;
constexpr double kHighM = 20000.0, kPixelM = 10.0;  // above the clouds, and at their height
constexpr double kMiddleM = 1500.0;
constexpr std::size_t kRun = 64;  // pixels of opaque cloud that a spectrum is of

struct Layers {
  std::uint32_t width, height;
  std::vector<float> texels;  // R G B T Z
  double luminance(std::size_t i) const {
    return 0.2126 * double(texels[5 * i]) + 0.7152 * double(texels[5 * i + 1]) + 0.0722 * double(texels[5 * i + 2]);
  }
  double transmittance(std::size_t i) const { return double(texels[5 * i + 3]); }
};

Layers layers_of(const Scene& scene, std::uint32_t width, std::uint32_t height) {
  auto renderer = Renderer::create(test_sky(), scene, {.width = width, .height = height});
  REQUIRE(renderer);
  (*renderer)->render(scene.camera, 0.0);
  return {width, height, (*renderer)->read_layers()};
}

Scene scene_file(const std::string& place) {
  auto scene = load_scene(std::string(NEPHELE_SOURCE_DIR) + "/tools/" + place + ".json");
  REQUIRE(scene);
  return *scene;
}

// Slope of the straight line through points.
double slope_of(const std::vector<double>& x, const std::vector<double>& y) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
  }
  const double n = double(x.size());
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

struct Outline {
  double area_m2, perimeter_m;
  bool whole;  // not cut by the picture's border
};

// Clouds as a satellite sees them: connected pixels that let less than half through.
std::vector<Outline> outlines_of(const Layers& picture) {
  const std::uint32_t side = picture.width;
  std::vector<char> cloud(std::size_t{side} * side), seen(cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud[i] = picture.transmittance(i) < 0.5;
  std::vector<Outline> found;
  std::vector<std::size_t> open;
  for (std::size_t start = 0; start < cloud.size(); ++start) {
    if (cloud[start] == 0 || seen[start] != 0) continue;
    Outline outline{0, 0, true};
    seen[start] = 1;
    open.assign(1, start);
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      outline.area_m2 += kPixelM * kPixelM;
      const std::size_t x = i % side, y = i / side;
      const auto neighbour = [&](bool inside, std::size_t j) {
        if (!inside)
          outline.whole = false;
        else if (cloud[j] == 0)
          outline.perimeter_m += kPixelM;
        else if (seen[j] == 0) {
          seen[j] = 1;
          open.push_back(j);
        }
      };
      neighbour(x > 0, i - 1);
      neighbour(x + 1 < side, i + 1);
      neighbour(y > 0, i - side);
      neighbour(y + 1 < side, i + side);
    }
    found.push_back(outline);
  }
  return found;
}

// The dimension D of P ~ A^(D / 2) [Lovejoy 1982] and the slope b of n(d) ~ d^-b, d the diameter of a disc of the
// cloud's area, up to a kilometre.
void print_outlines(const char* name, const std::vector<Outline>& outlines) {
  std::vector<double> area, perimeter;
  constexpr int kBins = 6;  // of sizes, from 80 m to 1 km
  std::vector<double> count(kBins, 0.0);
  const double first = std::log(80.0), width = (std::log(1000.0) - first) / kBins;
  for (const Outline& o : outlines) {
    const double size_m = std::sqrt(o.area_m2), diameter_m = 2.0 * size_m / std::sqrt(std::numbers::pi);
    if (o.whole && size_m > 50.0 && size_m < 3000.0) {
      area.push_back(std::log(o.area_m2));
      perimeter.push_back(std::log(o.perimeter_m));
    }
    const double bin = (std::log(diameter_m) - first) / width;
    if (bin >= 0 && bin < kBins) ++count[std::size_t(bin)];
  }
  std::vector<double> size, number;
  for (std::size_t i = 0; i < kBins; ++i)
    if (count[i] > 0) {
      size.push_back(first + (double(i) + 0.5) * width);
      number.push_back(std::log(count[i]) - size.back());  // of a metre of diameter: bins widen as it
    }
  std::printf("outlines | %s | %zu | %.2f | %.2f |\n", name, area.size(), 2.0 * slope_of(area, perimeter),
              -slope_of(size, number));
}

// How far the spectrum of luminance along rows of opaque cloud is off its power law: the smallest and the largest ratio
// between 300 m and two pixels, and where the largest is.
void print_spectrum(const char* name, const Layers& picture) {
  std::vector<double> power(kRun / 2 + 1, 0.0);
  std::size_t runs = 0;
  for (std::uint32_t y = 0; y < picture.height; ++y)
    for (std::uint32_t x = 0; x + kRun <= picture.width;) {
      const std::size_t at = std::size_t{y} * picture.width + x;
      std::size_t n = 0;
      double mean = 0;
      while (n < kRun && picture.transmittance(at + n) < 0.05) mean += picture.luminance(at + n++) / double(kRun);
      if (n < kRun) {
        x += std::uint32_t(n) + 1;
        continue;
      }
      for (std::size_t k = 1; k <= kRun / 2; ++k) {
        std::complex<double> sum = 0;
        for (std::size_t i = 0; i < kRun; ++i) {
          const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (double(i) + 0.5) / double(kRun));
          sum += window * (picture.luminance(at + i) / mean - 1.0) *
                 std::polar(1.0, -2 * std::numbers::pi * double(i * k) / double(kRun));
        }
        power[k] += std::norm(sum);
      }
      ++runs;
      x += kRun / 2;
    }
  std::vector<double> wave, log_power;
  for (std::size_t k = 2; k <= kRun / 2; ++k) {  // 320 m to 20 m
    wave.push_back(std::log(double(k)));
    log_power.push_back(std::log(power[k]));
  }
  const double slope = slope_of(wave, log_power);
  double middle = 0;
  for (std::size_t i = 0; i < wave.size(); ++i) middle += (log_power[i] - slope * wave[i]) / double(wave.size());
  double most = 0, least = 0, most_at_m = 0;
  for (std::size_t i = 0; i < wave.size(); ++i) {
    const double off = log_power[i] - slope * wave[i] - middle;
    if (off > most) most_at_m = double(kRun) * kPixelM / std::exp(wave[i]);
    most = std::max(most, off);
    least = std::min(least, off);
  }
  std::printf("spectrum | %s | %zu | %.2f | %.2f | %.2f | %.0f m |\n", name, runs, slope, std::exp(least),
              std::exp(most), most_at_m);
}

// Mean luminance of opaque cloud on one side of its middle over that on the other.
struct Sides {
  double left_right, top_base;
};
Sides sides_of(const Layers& picture, const Layers& opaque_in) {
  double mx = 0, my = 0, n = 0;
  const auto each = [&](auto visit) {
    for (std::uint32_t y = 0; y < picture.height; ++y)
      for (std::uint32_t x = 0; x < picture.width; ++x) {
        const std::size_t i = std::size_t{y} * picture.width + x;
        if (opaque_in.transmittance(i) < 0.1) visit(x, y, picture.luminance(i));
      }
  };
  each([&](double x, double y, double) {
    mx += x;
    my += y;
    ++n;
  });
  mx /= n;
  my /= n;
  double sum[4] = {}, count[4] = {};
  each([&](double x, double y, double luminance) {
    for (const int k : {x < mx ? 0 : 1, y < my ? 2 : 3}) {
      sum[k] += luminance;
      ++count[k];
    }
  });
  return {(sum[0] / count[0]) / (sum[1] / count[1]), (sum[2] / count[2]) / (sum[3] / count[3])};
}

void print_sides(const char* name) {
  const std::string file = std::string(NEPHELE_SOURCE_DIR) + "/tools/truth/" + name + "_layers.exr";
  const auto truth = read_exr(file);
  REQUIRE(truth);
  Layers traced{truth->width, truth->height, {}};
  for (std::uint32_t y = 0; y < truth->height; ++y)
    for (std::uint32_t x = 0; x < truth->width; ++x)
      for (const char* channel : {"R", "G", "B", "T", "Z"})
        traced.texels.push_back(truth->at(x, y, *truth->channel_index(channel)));
  const Layers ours = layers_of(scene_file(std::string("truth/") + name), truth->width, truth->height);
  const Sides a = sides_of(ours, traced), b = sides_of(traced, traced);
  std::printf("sides | %s | %.2f | %.2f | %.2f | %.2f |\n", name, a.left_right, b.left_right, a.top_base, b.top_base);
}

}  // namespace

TEST_CASE("shape study" * doctest::skip()) {
  for (const char* name : {"fair_weather", "towering", "above_deck"}) {
    std::vector<Outline> outlines;
    Scene scene = scene_file(std::string("scenes/") + name);
    Layers picture{0, 0, {}};
    for (const double east_m : {0.0, 11000.0, 22000.0}) {
      scene.camera = {.position_m = {east_m, 0.0, kMiddleM + kHighM},
                      .pitch_rad = -0.5 * std::numbers::pi,
                      .vertical_fov_rad = 2.0 * std::atan(0.5 * kSide * kPixelM / kHighM)};
      picture = layers_of(scene, kSide, kSide);
      const std::vector<Outline> more = outlines_of(picture);
      outlines.insert(outlines.end(), more.begin(), more.end());
    }
    print_outlines(name, outlines);
    print_spectrum(name, picture);
    std::fflush(stdout);
  }
  for (const char* name : {"cloud_side", "cloud_front", "field_side", "low_sun"}) {
    print_sides(name);
    std::fflush(stdout);
  }
}
