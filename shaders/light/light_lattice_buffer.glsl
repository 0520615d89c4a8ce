// Binding 0 of the light field's passes.
#ifndef NEPHELE_LIGHT_LATTICE_BUFFER_GLSL
#define NEPHELE_LIGHT_LATTICE_BUFFER_GLSL

#include "shared/light_lattice.h"

layout(scalar, set = 0, binding = 0) readonly buffer Lattice { LightLattice lattice; };

#endif
