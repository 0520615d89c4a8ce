// Binding 0 of every kernel of a cloud field.
#include "shared/field_constants.h"

layout(scalar, set = 0, binding = 0) uniform Field { FieldConstants constants; };
