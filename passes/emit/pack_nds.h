#pragma once

#include "formats/map/packed_nds.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass.h"

namespace sightline {

// The NDs of a map tile by tile as its file carries them, so that who writes the file need not hold
// them. Rounded (formats/map/layers.h). Errors: disk-full, cannot-write (temporary files).
Result<PackedNds> pack_nds_step(PassContext& ctx, const NoOptions& options, const TiledNds& nds);
inline constexpr Pass kPackNds =
    Pass{"pack-nds", 1, "packed-nds", "NDs as the map file carries them", &pack_nds_step}.in(
        Stage::kTiles);

}  // namespace sightline
