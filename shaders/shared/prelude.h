// One source, two compilers: every header in shaders/shared opens with this file and is then valid
// both as GLSL 4.60 and, through GLM, as C++20 (after Bruneton 2017, reference/functions.cc).
//
// Rules for shared code: write 1.0f; no swizzles beyond one component; no array constructors; no implicit
// int -> float conversions; functions marked NEPHELE_FN; out parameters as NEPHELE_OUT(type) name and
// NEPHELE_INOUT(type) name; constants as NEPHELE_CONST(type, kName, value).
#ifndef NEPHELE_SHARED_PRELUDE_H
#define NEPHELE_SHARED_PRELUDE_H

#ifdef __cplusplus
#include <glm/glm.hpp>
#include <glm/packing.hpp>

#include <cstdint>

namespace nephele::shared {
using namespace glm;  // vec3, clamp, mix, ...: the GLSL vocabulary
using uint = std::uint32_t;
inline std::uint32_t floatBitsToUint(float x) { return glm::floatBitsToUint(x); }
}  // namespace nephele::shared

#define NEPHELE_SHARED_BEGIN namespace nephele::shared {
#define NEPHELE_SHARED_END }
#define NEPHELE_FN inline
#define NEPHELE_OUT(type) type&
#define NEPHELE_INOUT(type) type&
#define NEPHELE_CONST(type, name, value) inline constexpr type name = value
#else
#define NEPHELE_SHARED_BEGIN
#define NEPHELE_SHARED_END
#define NEPHELE_FN
#define NEPHELE_OUT(type) out type
#define NEPHELE_INOUT(type) inout type
#define NEPHELE_CONST(type, name, value) const type name = value
#endif

NEPHELE_SHARED_BEGIN
NEPHELE_CONST(float, kPi, 3.14159265358979323846f);
NEPHELE_CONST(float, kPlanetRadiusM, 6360000.0f);
NEPHELE_SHARED_END

#endif
