#include "passes/emit/pack_model.h"

namespace sightline {

Result<PackedModel> pack_model_step(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                    const StoredErrorModel& model) {
  return pack_model(model);
}

}  // namespace sightline
