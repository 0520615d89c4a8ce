// The phase functions by the names that scene files, options and the tables' own files give them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string_view>

#include "shared/phase.h"

namespace nephele {

enum class PhaseFunction : std::uint32_t {
  henyey_greenstein = shared::kPhaseHenyeyGreenstein,
  cornette_shanks = shared::kPhaseCornetteShanks,
};

// In the order of the enumeration.
inline constexpr const char* kPhaseFunctionNames[] = {"hg", "cs"};

inline const char* phase_function_name(PhaseFunction function) {
  const auto place = static_cast<std::size_t>(function);
  return place < std::size(kPhaseFunctionNames) ? kPhaseFunctionNames[place] : "?";
}

inline std::optional<PhaseFunction> phase_function_named(std::string_view name) {
  for (const PhaseFunction function : {PhaseFunction::henyey_greenstein, PhaseFunction::cornette_shanks})
    if (name == phase_function_name(function)) return function;
  return std::nullopt;
}

inline constexpr double kMaxAsymmetry = 0.95;  // of a phase function, |g|: what the tables can be baked for

}  // namespace nephele
