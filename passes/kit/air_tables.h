// The atmosphere's tables as passes hand them to each other; AtmospherePass makes them.
#pragma once

#include "engine/resources.h"

namespace nephele {

// All RGBA32F, per unit of the sun's irradiance, read through shared/atmosphere_tables.h with a linear, clamped
// sampler.
struct AtmosphereTables {
  const Image& transmittance;     // to the top of the atmosphere: (way to the top, altitude)
  const Image& multi_scattering;  // mean radiance scattered more than once: (sun's height, altitude)
  const Image& sky_irradiance;    // and mean radiance: (sun's height, altitude: four blocks, kSkyIrradianceBlocks)
  const Image& sky_smooth;   // whole rays from the camera: (azimuth from the sun, elevation above | below the horizon)
  const Image& sky_aerosol;  // the same, aerosol's single scattering before its phase function
  const Image& view_transmittance;    // of those rays: (1, elevation)
  const Image& aerial_light;          // between camera and distance: (azimuth, elevation, distance)
  const Image& aerial_transmittance;  // the same
};

}  // namespace nephele
