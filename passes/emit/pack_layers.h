#pragma once

#include "formats/map/packed_model.h"
#include "formats/map/packed_nds.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass.h"

namespace sightline {

// The NDs of a map tile by tile as its file carries them, so that who writes the file need not hold
// them. Rounded (formats/map/layers.h). Errors: disk-full, cannot-write (temporary files).
struct PackNdsOptions {
  MapSize size = MapSize::kFull;
};
std::vector<OptionField> option_fields(PackNdsOptions& options);
Result<PackedNds> pack_nds_step(PassContext& ctx, const PackNdsOptions& options,
                                const TiledNds& nds);
inline constexpr Pass kPackNds =
    Pass{"pack-nds", 1, "packed-nds", "NDs packed for the map file", &pack_nds_step}.in(
        Stage::kTiles);

// Error model in the form of the map file, so that who writes the file need not hold it.
// Errors: cannot-read, disk-full, cannot-write (temporary files), out-of-memory.
Result<PackedModel> pack_model_step(PassContext& ctx, const NoOptions& options,
                                    const StoredErrorModel& model);
inline constexpr Pass kPackModel = Pass{"pack-model", 3, "packed-model",
                                        "The error model packed for the map file", &pack_model_step}
                                       .in(Stage::kLearn);

}  // namespace sightline
