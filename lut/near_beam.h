// Light that has been scattered more than once and is still near the beam: what the eye sees of it beside what the
// light field's ordinates carry (passes/light/light_field.h).
//
// In the scaled medium of the light field light scattered into the forward peak, a share f of all, counts as still in
// the beam, which decays as exp(-(1 - f) tau). The multiply scattered light of a beam that only widens (Goudsmit and
// Saunderson 1940, the small-angle solution) has the Legendre moments exp(-(1 - chi_l) tau), chi_l those of the phase
// function. Of those, degrees 0 and 1 are the lattice's business; its part is the scaled beam's. So per unit irradiance
// at optical depth tau, scattered once more into the angle with cosine mu:
//
//   4 pi K = (exp(-(1 - f) tau) - exp(-tau)) (1 + 3 chi_1 mu)
//            + sum over l >= 2 of (2 l + 1) chi_l (exp(-(1 - chi_l) tau) - exp(-tau)) P_l(mu)
#pragma once

#include <cstdint>

#include "engine/npy.h"

namespace nephele {

// K, per sr. phase_function: kPhaseHenyeyGreenstein or kPhaseCornetteShanks; |g| < 1; tau >= 0; -1 <= mu <= 1.
double near_beam_per_sr(std::uint32_t phase_function, double g, double tau, double mu);

// float16, [1][angle][depth][1]: K at the vertices of the axes of shaders/shared/near_beam_axes.h.
NpyArray bake_near_beam_array(std::uint32_t phase_function, double g, std::uint32_t depths, std::uint32_t angles);

}  // namespace nephele
