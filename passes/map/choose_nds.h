#pragma once

#include "formats/annotation/sites.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass.h"

namespace sightline {

struct ChooseNdsOptions {
  double far_m = 60.0;    // farther from the route no ND is kept
  double block_m = 8.0;   // edge of the cubes that keep NDs of each direction
  int per_direction = 2;  // in such a cube
  double near_m = 25.0;   // of the route: there all are kept
};
std::vector<OptionField> option_fields(ChooseNdsOptions& options);

// The NDs that a small map keeps, rounded to what it stores ("Small maps" in
// schemas/definitions.md): near the route, and in each cube those that hold a vehicle best in each
// direction. What is kept of a cube depends on that cube and the route alone. The passes behind
// this one use these NDs, so promises are calibrated with them. Errors: empty-map (none
// is left), those of reading and writing temporary files.
Result<TiledNds> choose_nds(PassContext& ctx, const ChooseNdsOptions& options, const TiledNds& nds,
                            const Sites& sites);
inline constexpr Pass kChooseNds =
    Pass{"choose-nds", 1, "chosen-nds", "NDs of a small map", &choose_nds}.in(Stage::kTiles);

}  // namespace sightline
