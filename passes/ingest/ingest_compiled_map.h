#pragma once

#include "formats/map/compiled_map.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass.h"

namespace sightline {

// The NDs of a compiled map as they are, to annotate it anew.
Result<NdtMap> ingest_compiled_map(PassContext& ctx, const NoOptions& options,
                                   const CompiledMap& map);
inline constexpr Pass kIngestCompiledMap =
    Pass{"ingest-compiled-map", 1, "nds", "NDs of a compiled map", &ingest_compiled_map}.in(
        Stage::kDrives);

}  // namespace sightline
