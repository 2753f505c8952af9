#include "passes/map/build_nd_surface.h"

#include <string>

#include "formats/tables/stored_table_writer.h"
#include "passes/map/surface/nd_surface.h"

namespace sightline {

Result<TiledSurface> build_nd_surface(PassContext& ctx, const NoOptions& /*options*/,
                                      const NdtMap& map) {
  const Surface surface = surface_of_nds(map);
  if (surface.patches.empty()) {
    return Error{ErrorCode::kEmptyMap, "the map has no valid cell that rays could hit", "",
                 "pass build-nd-surface"};
  }
  ctx.warn("a map file holds no surface: rays are cast on the flat patches of its " +
           std::to_string(map.nds.size()) +
           " NDs, which are rougher than its points were: occupancy_ratio, virtual scans and "
           "simulated errors are those of such patches. Annotate the points themselves where they "
           "are still there");
  StoredTableWriter<Surface> writer(surface);
  SIGHTLINE_TRY(writer.append(surface));
  return writer.take();
}

}  // namespace sightline
