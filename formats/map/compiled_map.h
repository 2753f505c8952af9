#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"
#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "formats/drive/recording_cards.h"
#include "formats/drive/sensor_profile.h"
#include "formats/drive/trajectory.h"
#include "formats/drive/unconstrained_stretches.h"
#include "formats/map/container/map_size.h"
#include "formats/model/error_model.h"
#include "formats/reader/map_layout.h"
#include "formats/record/fields.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/sharpness.h"
#include "formats/surroundings/tile_drives.h"

namespace sightline {

// Which scans made the map, which were matched against it, and how.
struct MeasurementCard {
  std::string mapping_drive;
  std::string mapping_scans = "all";  // all, even, odd: by index in the recording
  std::string localization_drive;
  std::string localization_scans = "all";
  ErrorReference reference = ErrorReference::kKnownPose;
  std::vector<InitialOffset> offsets;     // the same at every site
  std::uint32_t measured_site_count = 0;  // by the localizer whose errors the map predicts
  LocalizerProfile localizer;             // that was measured; what the map predicts is its model's
  // As in MatchingCard.
  std::uint32_t coarse_cells = 1;
  double leaf_m = 0.0;
  // Of a vehicle that tracks, and the looks whose errors the columns of sites are of: a range, and
  // a sample where there is one ("Errors by direction" in schemas/definitions.md). May be none.
  std::vector<InitialOffset> tracking_offsets;
  std::vector<Look> tracking_looks;
};
SIGHTLINE_FIELDS(MeasurementCard, mapping_drive, mapping_scans, localization_drive,
                 localization_scans, reference, offsets, measured_site_count, localizer,
                 coarse_cells, leaf_m, tracking_offsets, tracking_looks)

struct NamedVersion {
  std::string name;
  std::uint32_t version = 0;
};

// The error model as the map keeps it: a card that anyone can read, and the model itself in the
// encoding of its time, so that a map outlives changes of the model. A stripped map has no bytes.
struct ModelRecord {
  std::uint32_t encoding_version = 0;
  Digest digest{};             // SHA-256 of the bytes, also where they were stripped
  LocalizerProfile localizer;  // whose errors the model, and so the map, predicts
  std::vector<std::pair<std::string, std::string>> card;
  std::vector<CardFigure> figures;  // of facts of the card
  double mean_r_squared = 0.0;      // mean of RangeCard::r_squared over the ranges of the model
  std::vector<std::byte> bytes;

  bool operator==(const ModelRecord&) const = default;
};
// All but the bytes.
SIGHTLINE_SOME_FIELDS(ModelRecord, encoding_version, digest, localizer, card, figures,
                      mean_r_squared)

// What the map's own numbers say of one limit.
struct LimitQuality {
  std::uint32_t unmet_count = 0;         // sites where no range is good enough
  std::uint32_t extrapolated_count = 0;  // sites outside the model's support
  double mean_range_m = 0.0;
  double expected_coverage = 0.0;  // mean over sites of P(error <= limit) at the chosen range
  // Of the measured sites, those whose measured mean error at the chosen range is within the limit.
  // Where this drive also trained the model it is optimistic.
  double measured_coverage = 0.0;
};

// A piece of the mapping drive whose poses are known relative to each other (see TrajectoryPose).
struct TrajectoryPiece {
  std::uint32_t first_scan = 0;  // recording index
  std::int64_t stamp_ns = 0;     // of that scan
  std::uint32_t scan_count = 0;
  double way_m = 0.0;
  Eigen::Vector3d begin_map_m = Eigen::Vector3d::Zero();  // where the vehicle is at that scan
  friend bool operator==(const TrajectoryPiece&, const TrajectoryPiece&) = default;
};
SIGHTLINE_FIELDS(TrajectoryPiece, first_scan, stamp_ns, scan_count, way_m, begin_map_m)

// Where the mapping drive's poses came from, and what its pose graph left over (see Trajectory).
struct TrajectoryQuality {
  PoseSource source = PoseSource::kGiven;
  std::uint32_t odometry_edges = 0;  // 0: there was no graph
  std::uint32_t loop_edges = 0;
  std::uint32_t prior_edges = 0;
  double rms_translation_residual_m = 0.0;
  double rms_rotation_residual_rad = 0.0;
  std::vector<TrajectoryPiece> pieces = {};  // one, or how they lie to each other is not known
  // "Overlap" in schemas/definitions.md, v1, over the scans where it was measured.
  std::uint32_t overlap_count = 0;
  double median_overlap = 0.0;
  double least_overlap = 0.0;
  std::vector<UnconstrainedStretch> unconstrained = {};
  friend bool operator==(const TrajectoryQuality&, const TrajectoryQuality&) = default;
};
SIGHTLINE_FIELDS(TrajectoryQuality, source, odometry_edges, loop_edges, prior_edges,
                 rms_translation_residual_m, rms_rotation_residual_rad, pieces, overlap_count,
                 median_overlap, least_overlap, unconstrained)

// The annotation for looks that take a sample.
struct LooksOfMap {
  PredictedError predicted;
  RangeTable ranges;
  std::vector<LimitQuality> quality;  // one per limit
  FactorTable factors;                // without any where the map was stripped of them
};

// All that a map file carries.
struct CompiledMap {
  std::string map_id;              // names the recording and frame; the same for every release
  std::string version;             // for people
  std::uint64_t release = 1;       // only ever grows
  std::string writer;              // the program, with its version
  std::string world{kLocalWorld};  // where world coordinates lie (formats/geodesy.h, parse_world)
  NdtMap ndt;
  Sites sites;
  PredictedError predicted;  // and what follows of observation ranges
  RangeTable ranges;
  double reach_m = 10.0;  // a site farther away than this says nothing about a position; <= tile
  SensorProfile sensor;   // of the localizing drive
  MeasurementCard measurement;
  std::vector<NamedVersion> definitions;  // ascending name
  ModelRecord model;
  std::vector<LimitQuality> quality;            // one per limit
  std::optional<Sharpness> sharpness;           // none in maps made before it was measured
  std::optional<TrajectoryQuality> trajectory;  // none in maps made before it was kept
  std::optional<TileDrives> tile_drives;        // of a map of several drives
  // That the map and its errors were made from; none in maps made before they were kept.
  std::optional<RecordingCards> recordings;
  std::vector<SiteColumn> columns;  // further figures of each site, ascending name
  std::vector<Notice> notices;      // contradictions in the inputs that were accepted
  FactorTable factors;  // for engineers; without any factor where the map was stripped of them
  std::optional<LooksOfMap> looks;
  MapSize size = MapSize::kFull;
};

// As passes take them.
ByFamily<PredictedError> predicted_of(const CompiledMap& map);
ByFamily<RangeTable> choice_of(const CompiledMap& map);
ByFamily<FactorTable> factors_of(const CompiledMap& map);
ByFamily<const FactorTable*> factors_in(const CompiledMap& map);  // not copied

template <>
struct ArtifactTraits<CompiledMap> {
  static constexpr std::string_view kName = "compiled-map";
  static constexpr std::uint32_t kVersion = 1;
};

// Each artifact is valid, all share one frame, one set of sites, ranges and limits.
// Error: invalid-artifact.
Result<void> validate(const CompiledMap& map);
// Part of it: factors, or none, are of the map's sites and of what is chosen from; the tables may
// be without values. Error: invalid-artifact.
Result<void> validate_factors(const ByFamily<const FactorTable*>& factors, const CompiledMap& map);

// The facts of the map and, per site and limit, what a vehicle reads: joins sites and ranges.
Table dump(const CompiledMap& map);

// One artifact of the map as a table: nds, sites, predicted, ranges, factors,
// model, columns, tile-drives (no row where one drive made the map). Errors: unknown-name;
// of the model those of model_of().
Result<Table> dump(const CompiledMap& map, std::string_view name);
std::vector<std::string> dump_names();

// Rounds the places of sites and what is predicted there to what a small map keeps
// (kSmallLength_m, kSmallShare, kSmallRotation): along a street most bits are then equal. Choices,
// flags and reasons stay as they are.
void round_answers(CompiledMap& map);

ModelRecord record_of(const ByFamily<ErrorModel>& model);
// The same without bytes and digest, of the head of the ranges' model (encode_head).
ModelRecord card_record_of(const ErrorModel& head, std::size_t training_row_count);
// The model of the record. Errors: bad-layer (stripped, or it cannot be decoded), old-version,
// future-version, digest-mismatch.
Result<ByFamily<ErrorModel>> model_of(const ModelRecord& record);

TrajectoryQuality quality_of(const Trajectory& trajectory);
std::vector<TrajectoryPiece> pieces_of(const Trajectory& trajectory);
// One per limit, of a family; `measured`: null, or at the looks of the choice.
std::vector<LimitQuality> quality_of(const PredictedError& predicted, const RangeTable& ranges,
                                     const MeasuredError* measured);

}  // namespace sightline
