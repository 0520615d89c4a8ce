// Binding 0 of every kernel of a cloud field. Lavapipe compiles values of a uniform buffer into code that branches on
// them: kernels that would be compiled anew whenever the grid's origin moves define FIELD_IN_STORAGE.
#include "shared/field_constants.h"

#ifdef FIELD_IN_STORAGE
layout(scalar, set = 0, binding = 0) readonly buffer Field { FieldConstants constants; };
#else
layout(scalar, set = 0, binding = 0) uniform Field { FieldConstants constants; };
#endif
