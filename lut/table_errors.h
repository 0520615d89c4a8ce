// What a bake measures about its own tables and writes beside them.
#pragma once

#include <cstdint>
#include <functional>

#include "lut/cpu_fetch.h"

namespace nephele {

// Errors of the transmittance exp(-tau) of the reference particle at peak optical radius 8, over random chords (impact
// uniform in area), of the mean density that `fetched` gives for a chord against that of `truth`.
struct TransmittanceError {
  double rms = 0, bias = 0, p99 = 0;  // p99: of the magnitude
  double mean_density_rms = 0;        // of what is stored, before the exponential
};
using MeanDensity = std::function<double(const shared::vec3& entry, const shared::vec3& exit)>;
TransmittanceError transmittance_error(const MeanDensity& fetched, int chords, const MeanDensity& truth);
TransmittanceError transmittance_error(const FloatTexture& optical_depth, int chords, const MeanDensity& truth);

// Direct plus single plus multiple scattering, over the incident power, minus 1: what a sphere of this optical radius
// gains or loses. Single scattering by the formula that shading uses.
double energy_error(const FloatTexture& multiple_scattering, std::uint32_t phase_function, double g, double sigma);

// RMS error of the fetched near-beam light over its RMS, at depths and angles spread evenly over the axes between the
// table's vertices, against its series.
double near_beam_error(const FloatTexture& near_beam, std::uint32_t phase_function, double g);

}  // namespace nephele
