#include "passes/emit/pack_nds.h"

namespace sightline {

Result<PackedNds> pack_nds_step(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                const TiledNds& nds) {
  return pack_nds(nds);
}

}  // namespace sightline
