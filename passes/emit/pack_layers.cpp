#include "passes/emit/pack_layers.h"

namespace sightline {

std::vector<OptionField> option_fields(PackNdsOptions& options) {
  return {shared(choice("size", options.size, "what the map keeps", {"full", "promise"}))};
}

Result<PackedNds> pack_nds_step(PassContext& /*ctx*/, const PackNdsOptions& options,
                                const TiledNds& nds) {
  return pack_nds(nds, options.size);
}

Result<PackedModel> pack_model_step(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                    const StoredErrorModel& model) {
  return pack_model(model);
}

}  // namespace sightline
