#include "passes/ingest/ingest_compiled_map.h"

namespace sightline {

Result<NdtMap> ingest_compiled_map(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                   const CompiledMap& map) {
  return map.ndt;
}

}  // namespace sightline
