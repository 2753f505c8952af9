#include "passes/emit/pack_nds.h"

namespace sightline {

Result<PackedNds> pack_nds_step(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                const NdtMap& ndt) {
  return pack_nds(ndt);
}

}  // namespace sightline
