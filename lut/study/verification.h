// What nephele bake --verify measures: the tables as shading reads them, against independent truth (oracles.h).
#pragma once

#include "engine/result.h"
#include "lut/study/paper_tables.h"
#include "lut/tables.h"

namespace nephele {

// Measures both tables and writes "verification" into their metadata: how, how many rays, every error with its
// statistical uncertainty. Takes some 30 s on two idle cores;
// effort scales that, by fewer rays and paths.
void verify_tables(Tables& tables, const ProgressCallback& progress = {}, double effort = 1);
// The same of the paper's tables: transmittance, single scattering, energy and the power of orders 2 to 18.
void verify_tables(PaperTables& tables, const ProgressCallback& progress = {}, double effort = 1);

}  // namespace nephele
