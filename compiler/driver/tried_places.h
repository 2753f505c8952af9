#pragma once

#include <optional>

#include "compiler/config/expected_cost.h"
#include "compiler/driver/plans.h"
#include "compiler/pipeline/run_options.h"

namespace sightline {

// What the places of a finished map will cost, estimated by trying some of them: a few of several
// blocks go through the passes in which nearly all of the time is spent, with their options, on one
// thread, and nothing of it is kept. So machine, sensor, looks and scenery are those of the run.
// Nothing where surface or places are not in the cache yet, or what they are for is; NDs are made,
// and kept, where they are not. Inputs of the plan must be in `artifacts`. Errors: those of the
// passes and the cache.
Result<std::optional<ExpectedPlaces>> try_places(const CompilePlan& compile,
                                                 const RunOptions& options, ArtifactSet artifacts);

}  // namespace sightline
