#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/at_rest.h"
#include "formats/annotation/calibrated_plan.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/recording_cards.h"
#include "formats/drive/sensor_profile.h"
#include "formats/drive/trajectory.h"
#include "formats/foreign/maps/foreign_nds.h"
#include "formats/map/compiled_map.h"
#include "formats/map/map_file.h"
#include "formats/map/packed_model.h"
#include "formats/map/packed_nds.h"
#include "formats/surroundings/sharpness.h"
#include "formats/surroundings/tile_drives.h"
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
};
std::vector<OptionField> option_fields(EmitMapOptions& options);

struct EmitMapInputs {
  const Drive& mapping;
  const Drive& localization;
  const PackedNds& nds;
  const Sites& sites;
  const PredictedError& predicted;
  const RangeTable& ranges;
  AtRest<MeasuredError> measured;
  const PackedModel& model;
  AtRest<FactorTable> factors;
  const CalibratedPlan* plan = nullptr;            // where vehicles that track are told one
  const Sharpness* sharpness = nullptr;            // where it was measured
  const Trajectory* mapping_trajectory = nullptr;  // where its quality is to be kept
  const TileDrives* tile_drives = nullptr;         // where several drives made the map
};

// Joins what the passes before it made into the file of a map, tile by tile. The map id names the
// mapping drive's content and frame, so that compiling the same recording again gives another
// release of the same map. Where predictions were told of an earlier drive, what it measured joins
// the factors (passes/model/forest/measured_columns.h), unless it did before. Warns of sites that
// were not measured, and where the model foretells the errors of another localizer than the one
// that was measured, whose coverage is then left out. Errors: mismatched-inputs (sites, frames,
// ranges or limits differ), bad-value (version or id empty or not printable), disk-full,
// cannot-write (temporary files).
Result<MapFile> emit_map(PassContext& ctx, const EmitMapOptions& options,
                         const EmitMapInputs& inputs);

// The same as a pass.
Result<MapFile> emit_map_step(PassContext& ctx, const EmitMapOptions& options, const Drive& mapping,
                              const Drive& localization, const PackedNds& nds, const Sites& sites,
                              const PredictedError& predicted, const RangeTable& ranges,
                              const AtRest<MeasuredError>& measured, const PackedModel& model,
                              const AtRest<FactorTable>& factors, const CalibratedPlan& plan,
                              const Sharpness& sharpness, const Trajectory& mapping_trajectory);
inline constexpr Pass kEmitMap =
    Pass{"emit-map", 12, "map", "The map file", &emit_map_step}.in(Stage::kLink);

// The same of several drives: the map says which of them, and so which days, each tile is from.
Result<MapFile> emit_map_of_drives(PassContext& ctx, const EmitMapOptions& options,
                                   const Drive& mapping, const Drive& localization,
                                   const PackedNds& nds, const Sites& sites,
                                   const PredictedError& predicted, const RangeTable& ranges,
                                   const AtRest<MeasuredError>& measured, const PackedModel& model,
                                   const AtRest<FactorTable>& factors, const CalibratedPlan& plan,
                                   const Sharpness& sharpness, const Trajectory& mapping_trajectory,
                                   const TileDrives& tile_drives);
inline constexpr Pass kEmitMapOfDrives = variant_of(kEmitMap, &emit_map_of_drives);

// The same of a finished map that was annotated (schemas/definitions.md, "Annotating a finished
// map"): `recordings` names it first, `measured` is of a drive through it or simulated, the sensor
// the one that will localize. A simulation is no measurement: no site counts as measured by it.
Result<MapFile> emit_annotated_map(PassContext& ctx, const EmitMapOptions& wanted,
                                   const PackedNds& nds, const Sites& sites,
                                   const PredictedError& predicted, const RangeTable& ranges,
                                   const AtRest<MeasuredError>& measured, const PackedModel& model,
                                   const AtRest<FactorTable>& factors, const SensorProfile& sensor,
                                   const RecordingCards& recordings);
inline constexpr Pass kEmitAnnotatedMap = variant_of(kEmitMap, &emit_annotated_map);

// The same of a compiled map that was annotated anew: its world stays.
Result<MapFile> emit_map_anew(PassContext& ctx, const EmitMapOptions& wanted, const PackedNds& nds,
                              const Sites& sites, const PredictedError& predicted,
                              const RangeTable& ranges, const AtRest<MeasuredError>& measured,
                              const PackedModel& model, const AtRest<FactorTable>& factors,
                              const SensorProfile& sensor, const RecordingCards& recordings,
                              const CompiledMap& earlier);
inline constexpr Pass kEmitMapAnew = variant_of(kEmitMap, &emit_map_anew);

// The same of somebody's NDT map, in the world that it says it lies in.
Result<MapFile> emit_nd_map(PassContext& ctx, const EmitMapOptions& wanted, const PackedNds& nds,
                            const Sites& sites, const PredictedError& predicted,
                            const RangeTable& ranges, const AtRest<MeasuredError>& measured,
                            const PackedModel& model, const AtRest<FactorTable>& factors,
                            const SensorProfile& sensor, const RecordingCards& recordings,
                            const ForeignNds& finished);
inline constexpr Pass kEmitNdMap = variant_of(kEmitMap, &emit_nd_map);

}  // namespace sightline
