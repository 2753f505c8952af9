#pragma once

#include <string>
#include <vector>

#include "formats/annotation/calibrated_plan.h"
#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/recording_cards.h"
#include "formats/drive/sensor_profile.h"
#include "formats/drive/trajectory.h"
#include "formats/foreign/maps/foreign_maps.h"
#include "formats/map/compiled_map.h"
#include "formats/map/map_file.h"
#include "formats/map/packed_model.h"
#include "formats/map/packed_nds.h"
#include "formats/model/tracking_looks.h"
#include "formats/surroundings/sharpness.h"
#include "formats/surroundings/tile_drives.h"
#include "formats/tables/stored_table.h"
#include "passes/pass/pass.h"

namespace sightline {

struct EmitMapOptions {
  std::string map_id;           // empty: made of the mapping drive's content
  std::string version = "1";    // for people
  std::string world = "local";  // where world coordinates lie (formats/geodesy.h, parse_world)
  int release = 1;              // only ever grows
  double reach_m = 10.0;        // a site farther away than this says nothing about a position
  ScanSelection mapping_scans = ScanSelection::kAll;  // that made the map
  bool has_factors = true;                            // for engineers; no vehicle needs them
  MapSize size = MapSize::kFull;                      // what it keeps
};
std::vector<OptionField> option_fields(EmitMapOptions& options);

// Before hours of work. Errors: bad-value (version or id empty or not printable).
Result<void> check_options(const EmitMapOptions& options);

// What the passes before made.
struct EmitMapInputs {
  const PackedNds& nds;
  const Sites& sites;
  const ByFamily<PredictedError>& predicted;
  const ByFamily<RangeTable>& ranges;
  ByFamily<StoredTable<MeasuredError>> measured;
  const PackedModel& model;
  ByFamily<StoredTable<FactorTable>> factors;
  const SensorProfile& sensor;       // that will localize
  const RecordingCards& recordings;  // a finished map is the first of them
  // Of the drives that made the map; null where a finished map was annotated.
  const Drive* mapping = nullptr;
  const Trajectory* trajectory = nullptr;  // for its quality
  const Sharpness* sharpness = nullptr;
  const CalibratedPlan* plan = nullptr;     // of vehicles that track
  const TileDrives* tile_drives = nullptr;  // of several drives: which of them each tile is from
  // The finished map, where it keeps its world: one that was compiled before, or an NDT map.
  const CompiledMap* earlier = nullptr;
  const ForeignNds* foreign = nullptr;
  const TrackingLooks* tracking = nullptr;
  std::vector<SiteColumn> columns = {};  // further figures of each site, in any order
};

// Joins what the passes before it made into the file of a map, tile by tile. The map id is a digest
// of the mapping drive's content and frame, so that compiling the same recording again gives
// another release of the same map; of a finished map (schemas/definitions.md, "Annotating a
// finished map") it is a digest of that map. Where an earlier drive was an input of the
// predictions, its errors join the factors (passes/model/forest/measured_columns.h), unless they
// did before. A simulation is no measurement: no site counts as measured by it. Warns of sites that
// were not measured or only simulated, where the model predicts the errors of another localizer
// than the one that was measured, whose coverage is then left out, and where the errors of an
// earlier map's drives are lost. Errors: mismatched-inputs (sites, frames, ranges or limits
// differ), bad-value (version or id empty or not printable), disk-full, cannot-write (temporary
// files).
Result<MapFile> emit_map(PassContext& ctx, const EmitMapOptions& options,
                         const EmitMapInputs& inputs);

// The pass: emit_map() of its inputs.
Result<MapFile> emit_map_step(
    PassContext& ctx, const EmitMapOptions& options, const PackedNds& nds, const Sites& sites,
    const ByFamily<PredictedError>& predicted, const ByFamily<RangeTable>& ranges,
    const ByFamily<StoredTable<MeasuredError>>& measured, const PackedModel& model,
    const ByFamily<StoredTable<FactorTable>>& factors, const SensorProfile& sensor,
    const RecordingCards& recordings, const Drive* mapping, const Trajectory* trajectory,
    const Sharpness* sharpness, const CalibratedPlan* plan, const TileDrives* tile_drives,
    const CompiledMap* earlier, const ForeignNds* foreign, const TrackingLooks* tracking,
    Many<SiteColumn> columns);
inline constexpr Pass kEmitMap =
    Pass{"emit-map", 18, "map", "Map file", &emit_map_step}.in(Stage::kLink);

}  // namespace sightline
