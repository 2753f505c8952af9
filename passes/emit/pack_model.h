#pragma once

#include "formats/map/packed_model.h"
#include "passes/pass/pass.h"

namespace sightline {

// The error model as the map file carries it, so that who writes the file need not hold it.
// Errors: cannot-read, disk-full, cannot-write (temporary files), out-of-memory.
Result<PackedModel> pack_model_step(PassContext& ctx, const NoOptions& options,
                                    const StoredErrorModel& model);
inline constexpr Pass kPackModel =
    Pass{"pack-model", 3, "packed-model", "The error model as the map file carries it",
         &pack_model_step}
        .in(Stage::kLearn);

}  // namespace sightline
