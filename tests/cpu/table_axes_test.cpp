// Table axes are inverse pairs, cover their ranges and stay inside the table.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <set>

#include "shared/table_axes.h"

using namespace nephele::shared;

TEST_CASE("vertex-centred coordinates put the ends on texel centres") {
  CHECK(texture_from_axis(0.0f, 16.0f) == doctest::Approx(0.5 / 16));
  CHECK(texture_from_axis(1.0f, 16.0f) == doctest::Approx(15.5 / 16));
  for (const float t : {0.0f, 0.25f, 0.7f, 1.0f})
    CHECK(axis_from_texture(texture_from_axis(t, 24.0f), 24.0f) == doctest::Approx(t).epsilon(1e-6).scale(1));
}

TEST_CASE("normal cosine and density axes are round trips, increasing, onto [0, 1]") {
  float before = -1;
  for (int i = 0; i <= 1000; ++i) {
    const float c = -1.0f + 0.002f * static_cast<float>(i);
    const float t = axis_from_normal_cosine(c);
    CHECK(t > before);
    before = t;
    CHECK(normal_cosine_from_axis(t) == doctest::Approx(c).epsilon(1e-5).scale(1));
  }
  CHECK(axis_from_normal_cosine(-1.0f) == 0.0f);
  CHECK(axis_from_normal_cosine(0.0f) == 0.5f);
  CHECK(axis_from_normal_cosine(1.0f) == 1.0f);
  for (const float g : {0.0f, 0.7f, 0.85f, -0.9f}) {
    const float middle = density_axis_middle(g);
    CHECK(axis_from_optical_radius(0.0f, middle) == 0.0f);
    for (const float sigma : {1e-6f, 0.01f, 1.0f, 50.0f, 1e4f}) {
      const float t = axis_from_optical_radius(sigma, middle);
      CHECK(t < 1.0f);
      // 1 - t of a float near 1 keeps fewer digits: rounding times sigma / middle.
      CHECK(optical_radius_from_axis(t, middle) == doctest::Approx(sigma).epsilon(1e-6 + 1e-7 * sigma));
    }
  }
}

TEST_CASE("the azimuth's cosine undoes the spherical cosine rule and is tame at the poles") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 5000; ++i) {
    const double c = 0.999 * unit(random), h = 0.999 * std::abs(unit(random)), x = unit(random);
    const double mu = c * h + std::sqrt((1 - c * c) * (1 - h * h)) * x;
    // Rounding of mu over the smallest product of sines here, 0.002.
    CHECK(azimuth_cosine(float(c), float(h), float(mu)) == doctest::Approx(x).scale(1).epsilon(1e-3));
  }
  for (const float c : {-1.0f, 1.0f, 1.0000001f}) {
    const float x = azimuth_cosine(c, 0.5f, 0.5f * c);
    CHECK(std::abs(x) <= 1.0f);
  }
  CHECK(std::abs(azimuth_cosine(0.3f, 1.0f, 0.3f)) <= 1.0f);
}

TEST_CASE("the multiple scattering scale is positive, finite and vanishes with the chord and the density") {
  for (const float g : {-0.95f, -0.3f, 0.0f, 0.85f, 0.95f}) {
    for (const float sigma : {1e-6f, 0.5f, 100.0f, 1e4f}) {
      for (const float h : {1e-5f, 0.3f, 1.0f}) {
        for (const float mu : {-1.0f, 0.0f, 1.0f}) {
          const float scale = multiple_scattering_scale(h, mu, sigma, g);
          CHECK(scale > 0.0f);
          CHECK(std::isfinite(scale));
        }
      }
    }
    CHECK(multiple_scattering_scale(0.0f, 0.5f, 3.0f, g) == 0.0f);
    CHECK(multiple_scattering_scale(0.5f, 0.5f, 0.0f, g) == 0.0f);
  }
}

TEST_CASE("optical depth coordinates stay in their slice and are exact at vertices") {
  const float n = 32.0f;
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 20000; ++i) {
    vec3 s(normal(random), normal(random), normal(random)), e(normal(random), normal(random), normal(random));
    if (i % 4 == 0) s[i / 4 % 3] = 0.0f;  // on the folds and the axes
    const OpticalDepthCoordinates at = optical_depth_coordinates(normalize(s), normalize(e), n);
    CHECK(at.weight >= 0.0f);
    CHECK(at.weight <= 1.0f);
    for (const float z : {at.z0, at.z1}) {
      // Inside one row of S.v: from its first vertex to its last.
      const float texel = z * n * n - 0.5f;
      const float row = std::floor((texel + 0.5f) / n);
      CHECK(texel >= row * n - 1e-3f);
      CHECK(texel <= row * n + n - 1.0f + 1e-3f);
    }
    CHECK(at.z1 - at.z0 == doctest::Approx(1 / n));
    CHECK(min(at.exit_uv.x, at.exit_uv.y) >= 0.5f / n - 1e-6f);
    CHECK(max(at.exit_uv.x, at.exit_uv.y) <= 1.0f - 0.5f / n + 1e-6f);
  }
  const OpticalDepthCoordinates at = optical_depth_coordinates(octahedral_decode(vec2(3 / 31.0f, 5 / 31.0f)),
                                                               octahedral_decode(vec2(7 / 31.0f, 30 / 31.0f)), n);
  CHECK((at.z0 + at.weight / n) * n * n - 0.5f == doctest::Approx(5 * 32 + 3).epsilon(1e-5));
  CHECK(at.exit_uv.x * n - 0.5f == doctest::Approx(7).epsilon(1e-5));
  CHECK(at.exit_uv.y * n - 0.5f == doctest::Approx(30).epsilon(1e-5));
}

TEST_CASE("coarse vertices are every other and the last, and places among them are linear in between") {
  for (uint n = 4; n <= 64; ++n) {
    CAPTURE(n);
    const uint coarse = coarse_vertices(n);
    CHECK(coarse_vertex(0, n) == 0);
    CHECK(coarse_vertex(coarse - 1, n) == n - 1);
    CHECK(coarse_vertex(coarse - 2, n) < n - 1);
    for (uint k = 0; k < coarse; ++k) CHECK(coarse_place(float(coarse_vertex(k, n)), n) == float(k));
    for (uint k = 0; k + 1 < coarse; ++k)
      CHECK(coarse_place(0.5f * float(coarse_vertex(k, n) + coarse_vertex(k + 1, n)), n) == float(k) + 0.5f);
  }
}

TEST_CASE("packed words fill their table, each with a place of its own, and four of a group hold three cells") {
  for (uint vertex = 0; vertex < 128; ++vertex) REQUIRE(packed_group(vertex) == vertex / 3);
  for (const uint n : {3u, 4u, 5u, 8u, 17u}) {
    CAPTURE(n);
    CHECK(3 * packed_groups(n) >= n - 1);
    std::set<uint> places;
    for (uint w = 0; w < n; ++w)
      for (uint z = 0; z < n; ++z)
        for (uint y = 0; y < n; ++y)
          for (uint group = 0; group < packed_groups(n); ++group)
            places.insert(packed_along_exit_u(group, n) + packed_along_exit_v(y) + packed_along_entry_u(z, n) +
                          packed_along_entry_v(w, n));
    CHECK(places.size() == std::size_t{packed_groups(n)} * n * n * n);
    CHECK(*places.rbegin() < packed_words(n));
  }
}
