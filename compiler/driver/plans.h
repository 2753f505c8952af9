#pragma once

#include <string>
#include <vector>

#include "compiler/config/compile_config.h"
#include "compiler/pipeline/plan.h"
#include "formats/annotation/calibrated_plan.h"
#include "formats/annotation/drive_tracks.h"
#include "formats/annotation/measured_drives.h"
#include "formats/annotation/outside_errors.h"
#include "formats/annotation/site_column.h"
#include "formats/drive/route.h"
#include "formats/drive/trajectory.h"
#include "formats/evaluation/evaluation.h"
#include "formats/foreign/maps/foreign_maps.h"
#include "formats/map/compiled_map.h"
#include "formats/map/map_file.h"
#include "formats/map/packed_nds.h"
#include "formats/model/tracking_looks.h"
#include "formats/surroundings/sharpness.h"
#include "formats/surroundings/site_views.h"
#include "formats/surroundings/surface.h"
#include "formats/surroundings/surface_points.h"
#include "formats/surroundings/tile_drives.h"

// What the pipelines of verbs are made of: plans with the wires that their users provide or look
// at.

namespace sightline {

// Where the error model comes from: learnt from this compile's own localization drive, or made
// elsewhere and provided.
enum class ModelSource { kTrained, kGiven };

// One recording that a plan takes from outside.
struct RecordingInput {
  RecordingUse use = RecordingUse::kMapping;
  std::string role;  // section of the configuration: "mapping", "mapping-2", "localization", ...
  RecordingOptions options;
  Wire<Recording> recording;
  Wire<SensorProfile> sensor;
  Wire<Drive> drive;  // made: its scans as they were recorded
};

// A file of import-errors.
struct OutsideInput {
  std::string file;
  OutsideErrorsOptions options;
  Wire<OutsideErrors> errors;
};

// A finished map that a plan takes from outside in place of a mapping drive: its points, its NDs,
// or one that was compiled before.
struct FinishedMapInput {
  MapOptions options;
  RouteOptions route_options;
  std::string world;  // that the map is said to lie in
  // At most one of these is connected; none where a drive makes the map.
  Wire<PointMap> points;
  Wire<ForeignNds> nds;  // of an NDT map of another program
  Wire<CompiledMap> compiled;
  Wire<Route> route;           // not connected: everywhere
  Wire<SensorProfile> sensor;  // that will localize, where there is no localization drive
};

// A drive that is localized in a map.
struct LocalizedDrive {
  Wire<Drive> drive;
  Wire<Trajectory> trajectory;  // in the map's frame
  Wire<Drive> undistorted;
};

// From drives to a compiled map, or from a finished point cloud map and a route. What comes of a
// drive alone (drive, trajectory, undistorted, look_plan, sharpness) is not connected in the second
// case.
struct CompilePlan {
  Plan plan;
  // From outside; a split recording localizes by its own sensor, which is not provided again.
  std::vector<RecordingInput> recordings;
  bool learns_from_evaluation = false;  // the model does, from the evaluation drive
  std::vector<OutsideInput> outside;    // those that were named
  FinishedMapInput finished;
  Wire<RecordingCards> cards;
  Wire<RecordingCards> identified;         // made: they with the scans of the recordings
  Wire<ByFamily<ErrorModel>> given_model;  // connected where the model is given
  std::string base_file;
  Wire<ReleasedPoses> base;  // connected where an earlier map's poses stay
  // Made.
  Wire<Drive> drive;  // of the first sensor
  Wire<Trajectory> trajectory;
  Wire<ReleasedPoses> released;  // for the next map
  bool ships_poses = false;      // beside the map: it is of several drives
  Wire<Drive> of_first_sensor;   // its scans, undistorted
  Wire<Drive> undistorted;       // those of all sensors
  Wire<SurfacePoints> points;    // not connected where a finished map holds NDs
  Wire<NdtMap> ndt;
  Wire<PackedNds> packed_nds;  // the same, for the map file
  Wire<TiledSurface> surface;
  Wire<Sites> sites;
  Wire<DepthImages> depth;
  std::vector<Wire<SiteColumn>> columns;  // further figures of each site, which the map keeps
  Wire<SensorProfile> localizing_sensor;  // provided: of a recording, or of the finished map
  Wire<ByFamily<FactorTable>> factors;
  LocalizedDrive localized;                 // the first; a split recording by its own poses
  Wire<ByFamily<MeasuredError>> simulated;  // in a finished map
  // Of the localization drive, of several each in turn; in a finished map without: simulated.
  Wire<ByFamily<MeasuredError>> measured;
  // Of several localization drives, or with what a compiled map knew before; else not connected.
  Wire<MeasuredDrives> measured_drives;
  Wire<ByFamily<ErrorModel>> model;  // given or trained
  Wire<ByFamily<PredictedError>> predicted;
  Wire<ByFamily<FactorTable>> kept_factors;  // in the map, with what was an input of `predicted`
  Wire<ByFamily<RangeTable>> ranges;
  Wire<TrackingLooks> tracking_looks;
  Wire<CalibratedPlan> look_plan;
  Wire<Sharpness> sharpness;
  Wire<TileDrives> tile_drives;  // where several drives make the map; else not connected
  Wire<Evaluation> evaluation;
  Wire<MapFile> map;
};

// Judges a finished map by an independent drive, at the map's own ranges. Where that drive is the
// recording that also made the map, it is judged on the scans that the map did not use.
struct EvaluatePlan {
  Plan plan;
  // From outside.
  RecordingInput recording;
  std::vector<OutsideInput> outside;
  Wire<NdtMap> ndt;
  Wire<Sites> sites;
  Wire<ByFamily<PredictedError>> predicted;
  Wire<ByFamily<RangeTable>> ranges;
  Wire<ByFamily<FactorTable>> factors;
  bool judges_other_scans = false;  // those of the map's own drive that made no ND
  Wire<RecordingCards> cards;       // the drive's alone
  Wire<RecordingCards> identified;  // made: the card with its scans
  // Made, but for `measured` where it is provided.
  Wire<ByFamily<MeasuredError>> measured;
  Wire<Evaluation> evaluation;
  // Not connected where the drive is localized by another localizer than this program's own:
  // nothing replays it then.
  Wire<DriveTracks> tracks;
};

}  // namespace sightline
