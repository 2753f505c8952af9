#include "passes/emit/pack_layers.h"

namespace sightline {

Result<PackedNds> pack_nds_step(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                const TiledNds& nds) {
  return pack_nds(nds);
}

Result<PackedModel> pack_model_step(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                    const StoredErrorModel& model) {
  return pack_model(model);
}

}  // namespace sightline
