// What every table's JSON begins with, and its check.
#pragma once

#include <cstddef>
#include <vector>

#include <nlohmann/json.hpp>

#include "lut/tables.h"

namespace nephele {

nlohmann::json table_metadata(const char* name, const nlohmann::json& parameters, const NpyArray& array);

// Whether a loaded table is what `parameters` ask for, made by this version.
Result<void> check_table(const Table& table, const char* name, const nlohmann::json& parameters, ElementType type,
                         const std::vector<std::size_t>& shape);

}  // namespace nephele
