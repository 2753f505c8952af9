#include "passes/emit/emit_map.h"

#include <algorithm>
#include <optional>
#include <span>

#include "formats/base/files/stored_bytes.h"
#include "formats/base/hash.h"
#include "formats/base/version.h"
#include "formats/map/map_writer.h"
#include "formats/reader/site_errors.h"
#include "passes/emit/tracking_columns.h"
#include "passes/emit/unconstrained_sites.h"
#include "passes/model/forest/measured_columns.h"

namespace sightline {
namespace {

// Versions of the definitions in schemas/definitions.md by which a map's numbers were computed.
const std::vector<NamedVersion>& definitions() {
  static const std::vector<NamedVersion> kDefinitions = {{"choice-of-range", 5},
                                                         {"errors-by-direction", 1},
                                                         {"factor-of-mapping-drive", 4},
                                                         {"factors-of-the-paper", 1},
                                                         {"factors-of-virtual-scan", 5},
                                                         {"localizers", 3},
                                                         {"looks", 1},
                                                         {"measured-error", 3},
                                                         {"ndt-map", 1},
                                                         {"sites", 3},
                                                         {"surface", 4},
                                                         {"tracking-starts", 2}};
  return kDefinitions;
}

bool is_finished(const EmitMapInputs& inputs) { return inputs.mapping == nullptr; }

std::vector<NamedVersion> definitions_of(const EmitMapInputs& inputs) {
  std::vector<NamedVersion> all = definitions();
  if (is_finished(inputs)) all.insert(all.begin(), {"annotating-a-finished-map", 2});
  return all;
}

std::string derived_map_id(const Drive& mapping, const MapFrame& frame) {
  DigestBuilder builder;
  builder.add("sightline map id");
  builder.add(mapping.name);
  ByteWriter writer;
  encode(frame, writer);
  for (const ScanInfo& scan : mapping.scans) {
    writer.put(scan.recording_index);
    writer.put(scan.stamp_ns);
    writer.put(scan.point_count);
  }
  builder.add(writer.bytes());
  // 128 bits name a recording beyond doubt and still fit on a line.
  return to_hex(builder.finish()).substr(0, 32);
}

// Of a finished map: its content and frame.
std::string derived_map_id(const RecordingCard& finished, const MapFrame& frame) {
  DigestBuilder builder;
  builder.add("sightline id of an annotated map");
  builder.add(finished.digest);
  ByteWriter writer;
  encode(frame, writer);
  builder.add(writer.bytes());
  return to_hex(builder.finish()).substr(0, 32);
}

std::string derived_map_id(const EmitMapInputs& inputs) {
  return is_finished(inputs) ? derived_map_id(inputs.recordings.cards.front(), inputs.nds.frame)
                             : derived_map_id(*inputs.mapping, inputs.nds.frame);
}

const std::string& world_of(const EmitMapOptions& options, const EmitMapInputs& inputs) {
  if (inputs.earlier != nullptr && inputs.earlier->world != kLocalWorld) {
    return inputs.earlier->world;
  }
  if (inputs.foreign != nullptr) return inputs.foreign->world;
  return options.world;
}

bool is_printable(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c > ' ' && c <= '~'; });
}

Result<void> check_measured(const EmitMapInputs& inputs) {
  const StoredTable<MeasuredError>& measured = inputs.measured.ranges;
  if (measured.row_count() == inputs.sites.sites.size() &&
      measured.head().looks == inputs.ranges.ranges.looks) {
    return {};
  }
  return Error{
      ErrorCode::kMismatchedInputs,
      concat("errors were measured at ", measured.row_count(), " sites, expected the map's ",
             inputs.sites.sites.size(), " and the ranges that are chosen from")};
}

bool is_of_models_localizer(const EmitMapInputs& inputs) {
  return inputs.measured.ranges.head().matching.localizer == inputs.model.record.localizer;
}

bool is_simulated(const ByFamily<StoredTable<MeasuredError>>& measured) {
  return measured.ranges.head().reference == ErrorReference::kSimulated;
}

MeasurementCard card_of(const EmitMapOptions& options, const EmitMapInputs& inputs) {
  const MeasuredError& measured = inputs.measured.ranges.head();
  MeasurementCard card;
  card.mapping_drive =
      is_finished(inputs) ? inputs.recordings.cards.front().name : inputs.mapping->names_of_parts();
  card.mapping_scans = name_of(options.mapping_scans);
  // Of several drives the names of all.
  card.localization_drive = measured.drive;
  card.localization_scans = name_of(measured.matching.scans);
  card.reference = measured.reference;
  card.offsets = measured.offsets;
  card.localizer = measured.matching.localizer;
  card.coarse_cells = measured.matching.coarse_cells;
  card.leaf_m = measured.matching.leaf_m;
  if (is_of_models_localizer(inputs) && !is_simulated(inputs.measured)) {
    card.measured_site_count = static_cast<std::uint32_t>(
        std::ranges::count_if(measured.scan_of_site, [](std::int64_t scan) { return scan >= 0; }));
  }
  return card;
}

// What one localizer reached says nothing of the promise to another.
bool judges_map(const PassContext& ctx, const EmitMapInputs& inputs) {
  if (is_simulated(inputs.measured)) return false;
  if (is_of_models_localizer(inputs)) return true;
  const MeasuredError& measured = inputs.measured.ranges.head();
  ctx.warn(concat("the map predicts the errors of ", to_text(inputs.model.record.localizer),
                  ", but drive '", measured.drive, "' was localized by ",
                  to_text(measured.matching.localizer),
                  ", so no coverage was measured. Evaluate with a drive of the same localizer"));
  return false;
}

// Sets what the drive that was measured says of the promises. Errors: cannot-read.
Result<void> put_quality(const PassContext& ctx, const EmitMapInputs& inputs, CompiledMap& map) {
  std::optional<MeasuredError> ranges, samples;
  if (judges_map(ctx, inputs)) {
    SIGHTLINE_ASSIGN(ranges, inputs.measured.ranges.whole());
    if (inputs.measured.samples) {
      SIGHTLINE_ASSIGN(samples, inputs.measured.samples->whole());
    }
  }
  map.quality = quality_of(map.predicted, map.ranges, ranges ? &*ranges : nullptr);
  if (!map.looks) return {};
  LooksOfMap& looks = *map.looks;
  looks.quality = quality_of(looks.predicted, looks.ranges, samples ? &*samples : nullptr);
  return {};
}

bool must_add_measured(const EmitMapInputs& inputs) {
  const bool is_told = std::ranges::count(inputs.predicted.ranges.has_history, std::uint8_t{1}) > 0;
  return is_told && !has_measured_columns(inputs.factors.ranges.head());
}

void warn_of_simulated(const PassContext& ctx, const CompiledMap& map) {
  const std::uint32_t simulated = simulated_site_count(map.ranges);
  if (simulated == 0) return;
  ctx.warn(concat("simulated: no scan was recorded at ", simulated, " of ", map.sites.sites.size(),
                  " sites; their answers are from scans simulated in the map. Record a drive there "
                  "to measure them"));
}

void warn_of_lost_history(const PassContext& ctx, const EmitMapInputs& inputs) {
  if (inputs.earlier == nullptr || !has_measured_columns(inputs.earlier->factors) ||
      has_measured_columns(inputs.factors.ranges.head())) {
    return;
  }
  ctx.warn(
      "the errors that drives measured in the earlier map are not used in this one. A model of "
      "other places (--model) uses them, if sensor, ranges, looks and localizer are the same");
}

Error mismatched(const Error& error) {
  return {ErrorCode::kMismatchedInputs, error.message, "", error.place};
}

// Without quality and factors; none where looks that take a sample are not chosen from.
Result<std::optional<LooksOfMap>> looks_of(const EmitMapInputs& inputs) {
  if (inputs.ranges.samples.has_value() != inputs.predicted.samples.has_value()) {
    return mismatched(
        invalid_artifact("predictions and choices do not both have looks", "compiled map"));
  }
  if (!inputs.ranges.samples) return std::optional<LooksOfMap>();
  LooksOfMap looks{*inputs.predicted.samples, *inputs.ranges.samples, {}, {}};
  if (inputs.plan != nullptr) looks.ranges.plan = inputs.plan->plan;
  looks.quality.resize(looks.ranges.promises.size());
  return std::optional(std::move(looks));
}

void put_trajectory(const Trajectory& trajectory, CompiledMap& map) {
  map.trajectory = quality_of(trajectory);
  map.notices.insert(map.notices.end(), trajectory.notices.begin(), trajectory.notices.end());
  for (SiteColumn& column : unconstrained_columns(trajectory, map.sites)) {
    map.columns.push_back(std::move(column));
  }
}

// Errors by direction of a vehicle that tracks, where they are of the localizer that the map
// predicts and were measured. Error: cannot-read.
Result<void> put_tracking(const EmitMapInputs& inputs, CompiledMap& map) {
  if (!is_of_models_localizer(inputs) || is_simulated(inputs.measured)) return {};
  const auto put = [&](const StoredTable<MeasuredError>& measured,
                       std::span<const std::string_view> names) -> Result<void> {
    const std::optional<std::size_t> look = tracking_look(measured.head());
    if (!look) return {};
    map.measurement.tracking_offsets = measured.head().tracking_offsets;
    map.measurement.tracking_looks.push_back(measured.head().looks[*look]);
    SIGHTLINE_ASSIGN(const MeasuredError whole, measured.whole());
    for (SiteColumn& column : tracking_columns(whole, *look, map.sites, names)) {
      map.columns.push_back(std::move(column));
    }
    return {};
  };
  SIGHTLINE_TRY(put(inputs.measured.ranges, kTrackingRangeColumns));
  if (!inputs.measured.samples) return {};
  return put(*inputs.measured.samples, kTrackingSampleColumns);
}

// With those of a compiled map that is annotated anew; nothing where that lists none.
std::optional<RecordingCards> recordings_of(const EmitMapInputs& inputs) {
  RecordingCards recordings = inputs.recordings;
  if (inputs.earlier == nullptr) return recordings;
  if (!inputs.earlier->recordings) return std::nullopt;
  for (RecordingCard card : inputs.earlier->recordings->cards) {
    card.role = "map." + card.role;
    recordings.cards.push_back(std::move(card));
  }
  return recordings;
}

// All of the map but its NDs and factors.
Result<CompiledMap> answers_of(const PassContext& ctx, const EmitMapOptions& options,
                               const EmitMapInputs& inputs) {
  SIGHTLINE_TRY(check_options(options));
  SIGHTLINE_TRY(check_measured(inputs));
  CompiledMap map;
  map.map_id = options.map_id.empty() ? derived_map_id(inputs) : options.map_id;
  map.version = options.version;
  map.release = static_cast<std::uint64_t>(options.release);
  map.writer = "sightline " + program_version();
  map.world = world_of(options, inputs);
  map.ndt = without_nds(inputs.nds);
  map.sites = inputs.sites;
  map.predicted = inputs.predicted.ranges;
  map.ranges = inputs.ranges.ranges;
  SIGHTLINE_ASSIGN(map.looks, looks_of(inputs));
  map.reach_m = options.reach_m;
  map.sensor = inputs.sensor;
  map.measurement = card_of(options, inputs);
  map.definitions = definitions_of(inputs);
  map.model = inputs.model.record;
  map.recordings = recordings_of(inputs);
  if (inputs.sharpness != nullptr) map.sharpness = *inputs.sharpness;
  map.columns = inputs.columns;
  if (inputs.mapping != nullptr) map.notices = inputs.mapping->notices;
  if (inputs.trajectory != nullptr) put_trajectory(*inputs.trajectory, map);
  if (inputs.tile_drives != nullptr) map.tile_drives = *inputs.tile_drives;
  SIGHTLINE_TRY(put_tracking(inputs, map));
  if (inputs.tracking != nullptr) {
    const std::vector<SiteColumn>& looks = inputs.tracking->columns;
    map.columns.insert(map.columns.end(), looks.begin(), looks.end());
  }
  std::ranges::sort(map.columns, {}, &SiteColumn::name);
  map.quality.resize(map.ranges.promises.size());
  map.size = options.size;
  if (map.size == MapSize::kPromise) round_answers(map);
  const Result<void> valid = validate(map);
  if (!valid) return mismatched(valid.error());
  SIGHTLINE_TRY(put_quality(ctx, inputs, map));
  const std::size_t unmeasured = map.sites.sites.size() - map.measurement.measured_site_count;
  const std::size_t spoken_for = std::size_t{map.measurement.measured_site_count} *
                                 inputs.measured.ranges.head().matching.site_step;
  const bool is_measured = !is_simulated(inputs.measured);
  if (spoken_for < map.sites.sites.size() && is_of_models_localizer(inputs) && is_measured) {
    ctx.warn(
        concat("no scan was matched at ", unmeasured, " of ", map.sites.sites.size(), " sites"));
  }
  if (is_finished(inputs)) warn_of_simulated(ctx, map);
  return map;
}

Result<MapFile> file_of(const EmitMapOptions& options, const EmitMapInputs& inputs,
                        const CompiledMap& answers) {
  // None, or with the earlier errors that predictions used.
  ByFamily<StoredTable<FactorTable>> factors;
  if (options.has_factors && must_add_measured(inputs)) {
    SIGHTLINE_ASSIGN(const ByFamily<FactorTable> untold, whole_of(inputs.factors));
    SIGHTLINE_ASSIGN(const ByFamily<MeasuredError> measured, whole_of(inputs.measured));
    factors = with_measured_columns(untold, measured);
  } else if (options.has_factors) {
    factors = inputs.factors;
  }
  const Result<void> valid = validate_factors(factors, answers);
  if (!valid) return mismatched(valid.error());
  constexpr std::size_t kMostInMemory = std::size_t{16} << 20;
  GrowingBytes bytes(kMostInMemory);
  // Written from front to back, but for the header.
  const auto write = [&](std::uint64_t offset, std::span<const std::byte> piece) {
    return offset < bytes.size() ? bytes.replace(offset, piece) : bytes.append(piece);
  };
  SIGHTLINE_TRY(write_map({answers, inputs.nds, inputs.model, factors}, write));
  return MapFile{bytes.take(), answers.model.localizer};
}

}  // namespace

Result<void> check_options(const EmitMapOptions& options) {
  const auto refused = [](const char* key, const std::string& found) {
    return Error{ErrorCode::kBadValue, concat("emit-map.", key, ": found '", found,
                                              "', expected printable ASCII without spaces")};
  };
  if (!is_printable(options.version)) return refused("version", options.version);
  if (!options.map_id.empty() && !is_printable(options.map_id)) {
    return refused("map_id", options.map_id);
  }
  return {};
}

std::vector<OptionField> option_fields(EmitMapOptions& options) {
  return {
      text("map_id", options.map_id, "name of the map; empty: derived from the recording"),
      text("version", options.version, "version, free text"),
      shared(text("world", options.world, "coordinate system of the recordings' poses")),
      integer("release", options.release, "release number; raise it with each release", 1,
              2'000'000'000),
      number("reach_m", options.reach_m,
             "largest distance from a position to the site that answers for it, m", 0.1, 1000.0),
      shared(choice("mapping_scans", options.mapping_scans, "scans that make the map",
                    {"all", "even", "odd"})),
      flag("has_factors", options.has_factors,
           "store the map factors, which inspect --site uses to explain a range"),
      choice("size", options.size,
             "what the map keeps: full, or promise: rounded, and only the NDs that its answers "
             "need; everything is measured in what it keeps",
             {"full", "promise"})};
}

Result<MapFile> emit_map(PassContext& ctx, const EmitMapOptions& options,
                         const EmitMapInputs& inputs) {
  warn_of_lost_history(ctx, inputs);
  SIGHTLINE_ASSIGN(const CompiledMap answers, answers_of(ctx, options, inputs));
  return file_of(options, inputs, answers);
}

Result<MapFile> emit_map_step(
    PassContext& ctx, const EmitMapOptions& options, const PackedNds& nds, const Sites& sites,
    const ByFamily<PredictedError>& predicted, const ByFamily<RangeTable>& ranges,
    const ByFamily<StoredTable<MeasuredError>>& measured, const PackedModel& model,
    const ByFamily<StoredTable<FactorTable>>& factors, const SensorProfile& sensor,
    const RecordingCards& recordings, const Drive* mapping, const Trajectory* trajectory,
    const Sharpness* sharpness, const CalibratedPlan* plan, const TileDrives* tile_drives,
    const CompiledMap* earlier, const ForeignNds* foreign, const TrackingLooks* tracking,
    Many<SiteColumn> columns) {
  EmitMapInputs inputs{nds,     sites,       predicted,  ranges,  measured,   model,
                       factors, sensor,      recordings, mapping, trajectory, sharpness,
                       plan,    tile_drives, earlier,    foreign, tracking};
  for (const SiteColumn* column : columns) inputs.columns.push_back(*column);
  return emit_map(ctx, options, inputs);
}

}  // namespace sightline
