// Every table of the atmosphere as the device fills it, against the same code on the CPU fed with the device's own
// earlier tables.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "shared/atmosphere_tables.h"
#include "tests/support/sky_frame.h"

using namespace nephele;
using namespace nephele::shared;

namespace {

struct Texels {
  std::vector<glm::vec4> values;
  Table3D table;
};

Texels read(const Image& image) {
  const VkExtent3D size = image.extent();
  Texels texels;
  texels.values.resize(std::size_t{size.width} * size.height * size.depth);
  image.read(std::as_writable_bytes(std::span(texels.values)));
  texels.table = {int(size.width), int(size.height), int(size.depth), texels.values.data()};
  return texels;
}

// Largest difference relative to the value, or to a hundredth of the table's largest.
class Worst {
 public:
  explicit Worst(const Texels& texels) {
    for (const glm::vec4& v : texels.values) largest_ = std::max({largest_, v.x, v.y, v.z});
  }
  void add(const glm::vec4& got, const glm::vec3& wanted) {
    for (int c = 0; c < 3; ++c) {
      const float error = std::abs(got[c] - wanted[c]) / std::max(std::abs(wanted[c]), 0.01f * largest_);
      worst_ = error <= worst_ ? worst_ : error;  // a NaN sticks
    }
  }
  float get() const { return worst_; }

 private:
  float largest_ = 0, worst_ = 0;
};

// A device may filter with 8-bit weights: 1/256 of the difference between texels. Lavapipe is ten times better.
constexpr float kTolerance = 0.01f;

}  // namespace

TEST_CASE("the atmosphere's tables agree with the CPU") {
  Device& device = test::test_device();
  Workshop make(test::test_kernels());
  AtmospherePass pass(make);
  FrameExecutor executor(device);
  for (const auto& [altitude_m, sun_deg] :
       {std::pair{2.0, 45.0}, {1500.0, 3.0}, {11000.0, -4.0}, {40000.0, 70.0}, {250000.0, 10.0}}) {
    CAPTURE(altitude_m);
    CAPTURE(sun_deg);
    const FrameConstants constants = test::sky_constants({.altitude_m = altitude_m, .sun_elevation_deg = sun_deg});
    Buffer buffer(device, "constants", sizeof constants);
    buffer.write(std::as_bytes(std::span(&constants, 1)));
    FrameBuilder frame(device);
    const AtmosphereTables& tables = pass.add(frame, constants, buffer, {.ground_albedo = constants.ground_albedo});
    executor.run(frame);

    const Texels transmittance = read(tables.transmittance), multi_scattering = read(tables.multi_scattering);
    const Texels sky_irradiance = read(tables.sky_irradiance);
    if (altitude_m == 2.0) {
      Worst a(transmittance), b(multi_scattering), c(sky_irradiance);
      for (std::uint32_t y = 0; y < kTransmittanceHeight; ++y)
        for (std::uint32_t x = 0; x < kTransmittanceWidth; ++x)
          a.add(transmittance.values[y * kTransmittanceWidth + x], transmittance_texel(uvec2(x, y)));
      for (std::uint32_t y = 0; y < kMultiScatteringHeight; y += 3)
        for (std::uint32_t x = 0; x < kMultiScatteringWidth; x += 3)
          b.add(multi_scattering.values[y * kMultiScatteringWidth + x],
                multi_scattering_texel(transmittance.table, uvec2(x, y), constants.ground_albedo));
      for (std::uint32_t y = 0; y < kSkyIrradianceBlocks * kSkyIrradianceHeight; y += 5)
        for (std::uint32_t x = 0; x < kSkyIrradianceWidth; x += 7)
          c.add(
              sky_irradiance.values[y * kSkyIrradianceWidth + x],
              sky_irradiance_texel(transmittance.table, multi_scattering.table, uvec2(x, y), constants.ground_albedo));
      CHECK(a.get() < kTolerance);
      CHECK(b.get() < kTolerance);
      CHECK(c.get() < kTolerance);
    }

    const float h = constants.camera_grid_m.z, sun_mu = constants.sun_direction.z;
    const Texels smooth = read(tables.sky_smooth), aerosol = read(tables.sky_aerosol),
                 through = read(tables.view_transmittance);
    Worst d(smooth), e(aerosol), f(through);
    for (std::uint32_t y = 0; y < kSkyViewHeight; ++y) {
      for (std::uint32_t x = 0; x < kSkyViewWidth; x += 5) {
        const ViewMarch march = sky_view_texel(transmittance.table, multi_scattering.table, uvec2(x, y), h, sun_mu);
        d.add(smooth.values[y * kSkyViewWidth + x], march.smooth_light);
        e.add(aerosol.values[y * kSkyViewWidth + x], march.aerosol_light);
        if (x == 0) f.add(through.values[y], march.transmittance);
      }
    }
    CHECK(d.get() < kTolerance);
    CHECK(e.get() < kTolerance);
    CHECK(f.get() < kTolerance);

    const Texels light = read(tables.aerial_light), clear = read(tables.aerial_transmittance);
    Worst g(light), i(clear);
    for (std::uint32_t y = 0; y < kAerialElevations; y += 4) {
      for (std::uint32_t x = 0; x < kAerialAzimuths; x += 4) {
        const ViewRay ray = aerial_ray(uvec2(x, y), h, sun_mu);
        const float near_m = aerial_near_m(h, ray.cos_zenith), reach_m = aerial_reach_m(h);
        ViewMarch march = begin_march(ray, near_m);
        for (std::uint32_t z = 0; z < kAerialDistances; ++z) {
          const float t = distance_from_unit(unit_from_index(z, kAerialDistances), near_m, reach_m);
          if (z > 0) march_to(transmittance.table, multi_scattering.table, ray, t, march);
          const std::size_t at = (std::size_t{z} * kAerialElevations + y) * kAerialAzimuths + x;
          g.add(light.values[at], march.smooth_light + march.aerosol_light * aerosol_phase(ray.sun_cos_view));
          i.add(clear.values[at], march.transmittance);
        }
      }
    }
    CHECK(g.get() < kTolerance);
    CHECK(i.get() < kTolerance);
  }
}

TEST_CASE("tables are made once, and again for another ground, altitude or sun") {
  Device& device = test::test_device();
  Workshop make(test::test_kernels());
  AtmospherePass pass(make);
  FrameExecutor executor(device);
  FrameConstants constants = test::sky_constants({});
  Buffer buffer(device, "constants", sizeof constants);
  const auto steps = [&](glm::vec3 albedo, bool aerial, Reuse reuse = Reuse::all) {
    buffer.write(std::as_bytes(std::span(&constants, 1)));
    FrameBuilder frame(executor, reuse);
    pass.add(frame, constants, buffer, {.ground_albedo = albedo, .aerial_perspective = aerial});
    executor.run(frame);
    return frame.declarations().size();
  };
  CHECK(steps(glm::vec3(0.1f), false) == 4);
  const Texels dark = read(pass.tables().sky_irradiance);
  CHECK(steps(glm::vec3(0.1f), false) == 0);
  CHECK(steps(glm::vec3(0.1f), true) == 1);
  CHECK(steps(glm::vec3(0.1f), true) == 0);
  CHECK(read(pass.tables().sky_irradiance).values == dark.values);
  CHECK(steps(glm::vec3(0.8f), true) == 4);
  const Texels bright = read(pass.tables().sky_irradiance);
  // Over snow the light from below is several times that over a dark ground, and the sky itself is brighter.
  const vec3 below_dark = sky_irradiance_from_below(dark.table, 1000.0f, 0.7f),
             below_bright = sky_irradiance_from_below(bright.table, 1000.0f, 0.7f);
  CHECK(below_bright.y > 3.0f * below_dark.y);
  CHECK(sky_irradiance_from_above(bright.table, 0.0f, 0.7f).y > sky_irradiance_from_above(dark.table, 0.0f, 0.7f).y);
  constants.camera_grid_m.z += 0.25f;
  CHECK(steps(glm::vec3(0.8f), true) == 2);
  constants.sun_direction.z += 1e-6f;
  CHECK(steps(glm::vec3(0.8f), true) == 2);
  CHECK(steps(glm::vec3(0.8f), true, Reuse::lasting) == 2);
}
