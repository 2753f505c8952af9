#include "compiler/driver/provide_inputs.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "compiler/config/inputs.h"
#include "compiler/driver/plans.h"
#include "compiler/store/cache.h"
#include "formats/base/files/atomic_file.h"
#include "formats/foreign/lanes/read_route.h"
#include "formats/foreign/maps/apollo_map.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/recording/same_recording.h"
#include "formats/foreign/text/outside_errors_file.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/delta/delta_steps.h"
#include "formats/map/map_reader.h"
#include "formats/text/table.h"
#include "passes/emit/emit_map.h"
#include "passes/matching/localizer.h"

namespace sightline {
namespace {

// In the cache, among the artifacts.
class CachedDigests : public DigestMemory {
 public:
  explicit CachedDigests(const std::filesystem::path& cache_directory) : cache_(cache_directory) {}

  [[nodiscard]] std::optional<std::vector<std::byte>> load(const Digest& key) const override {
    if (!cache_.is_enabled()) return std::nullopt;
    Result<ArtifactCache::Content> found = cache_.load(kName, key);
    if (!found || !*found) return std::nullopt;
    cache_.mark_used(kName, key);
    return *std::move(found);
  }
  void store(const Digest& key, std::span<const std::byte> content) const override {
    if (cache_.is_enabled()) (void)cache_.store(kName, key, content);
  }

 private:
  static constexpr const char* kName = "scan-digests";
  ArtifactCache cache_;
};

// For all drives together.
std::shared_ptr<ScanMemory> new_scan_memory() {
  return std::make_shared<ScanMemory>(ScanMemory::kMost_bytes, ScanMemory::kMost_scans);
}

Result<void> provide_recording(const RecordingInput& input, const CachedDigests& digests,
                               const std::shared_ptr<ScanMemory>& memory, ArtifactSet& artifacts) {
  Result<Recording> recording = open_recording(input.options, /*threads=*/0, &digests);
  if (!recording) {
    Error error = recording.error();
    if (error.code == ErrorCode::kFileNotFound) {
      error.message += concat(" (section ", input.role,
                              "; its paths are relative to the folder of the configuration)");
    }
    return error;
  }
  recording->memory = memory;
  const Digest digest = recording->digest;
  artifacts.provide(input.sensor, recording->sensor);
  artifacts.provide(input.recording, std::move(*recording), digest);
  return {};
}

// Coordinates that are as large are in another unit than metres, or of a system that has a name.
Result<void> check_near(const RecordingInput& input, const ArtifactSet& artifacts) {
  constexpr double kFarthest_m = 1e7;
  for (const RecordedScan& scan : artifacts.get(input.recording).scans) {
    if (!scan.T_world_vehicle) continue;
    const Eigen::Vector3d p_world_m = scan.T_world_vehicle->translation();
    if (p_world_m.cwiseAbs().maxCoeff() <= kFarthest_m) continue;
    return Error{ErrorCode::kMissingKey,
                 concat("annotation.world is missing: a pose of ", input.role, " is at ",
                        format_double(p_world_m.x()), ", ", format_double(p_world_m.y()), ", ",
                        format_double(p_world_m.z()),
                        " m, more than 10 000 km from the origin; name the coordinate system, or "
                        "write metres"),
                 input.options.poses};
  }
  return {};
}

// By the contents of their scans, so that copies are found too. An evaluation drive may be one of
// the others where nothing is learnt from it.
Result<void> check_named_once(const CompilePlan& compile, const ArtifactSet& artifacts) {
  std::map<Digest, const RecordingInput*> input_of;
  for (const RecordingInput& input : compile.recordings) {
    if (input.use == RecordingUse::kEvaluation && !compile.learns_from_evaluation) continue;
    const auto [other, is_new] =
        input_of.try_emplace(scans_digest(artifacts.get(input.recording)), &input);
    if (is_new) continue;
    return Error{ErrorCode::kBadValue,
                 concat(input.role, ".scans: found the recording of ", other->second->role, " (",
                        other->second->options.scans,
                        "), expected another drive: the same recording is listed twice"),
                 input.options.scans};
  }
  return {};
}

Result<void> provide_outside(const std::vector<OutsideInput>& inputs, ArtifactSet& artifacts) {
  for (const OutsideInput& input : inputs) {
    OutsideErrors outside;
    outside.file = std::filesystem::path(input.file).filename().string();
    SIGHTLINE_ASSIGN(outside.localizer, outside_localizer(input.options));
    outside.reference = input.options.reference;
    SIGHTLINE_ASSIGN(outside.errors, read_outside_errors(input.file));
    artifacts.provide(input.errors, std::move(outside));
  }
  return {};
}

Result<void> provide_route(const FinishedMapInput& input, const std::string& world_name,
                           ArtifactSet& artifacts) {
  if (!input.route.is_connected()) return {};
  SIGHTLINE_ASSIGN(const World world, parse_world(world_name));
  SIGHTLINE_ASSIGN(Route route, read_route(input.route_options.file, world));
  artifacts.provide(input.route, std::move(route));
  return {};
}

// Where no sensor is configured, that of an earlier map.
Result<SensorProfile> localizing_sensor(const MapOptions& options, const CompiledMap* earlier) {
  RecordingOptions localizing = options.localizing;
  if (!localizing.sensor.empty()) return sensor_of(localizing);
  localizing.sensor = RecordingOptions{}.sensor;
  if (earlier == nullptr) return sensor_of(localizing);
  SIGHTLINE_ASSIGN(const SensorProfile said, sensor_of(localizing));
  SIGHTLINE_ASSIGN(const SensorProfile usual, sensor_of(RecordingOptions{}));
  if (to_bytes(said) == to_bytes(usual)) return earlier->sensor;
  return Error{ErrorCode::kBadValue,
               concat("map.sensor: found height, beams or mounting without the name of the sensor; "
                      "name it, or remove these keys to use that of the compiled map (",
                      earlier->sensor.name, ")")};
}

// A map keeps its world: what else is named has to be the same.
Result<void> check_world(const std::string& key, const std::string& named, const std::string& world,
                         const std::string& file) {
  if (named == kLocalWorld || named == world) return {};
  return Error{ErrorCode::kBadValue,
               concat(key, ": found ", named, ", but the coordinate system of the compiled map is ",
                      world, "; remove this key"),
               file};
}

// A map that was compiled before. Errors: those of read_map; bad-value.
Result<void> provide_compiled(const FinishedMapInput& input, ArtifactSet& artifacts) {
  const std::string& file = input.options.points;
  SIGHTLINE_ASSIGN(const MapSummary summary, verify_map(file));
  SIGHTLINE_ASSIGN(CompiledMap map, read_map(file));
  const bool is_placed = map.world != kLocalWorld;
  if (is_placed) {
    SIGHTLINE_TRY(check_world("annotation.world", input.world, map.world, file));
    SIGHTLINE_TRY(check_world("route.world", input.route_options.world, map.world, file));
  }
  SIGHTLINE_TRY(provide_route(input, is_placed ? map.world : input.route_options.world, artifacts));
  SIGHTLINE_ASSIGN(SensorProfile sensor, localizing_sensor(input.options, &map));
  artifacts.provide(input.sensor, std::move(sensor));
  artifacts.provide(input.compiled, std::move(map), summary.root_digest);
  return {};
}

// Somebody's NDT map. Errors: those of open_apollo_map; bad-value.
Result<void> provide_nds(const FinishedMapInput& input, ArtifactSet& artifacts) {
  const std::string& file = input.options.points;
  SIGHTLINE_ASSIGN(SensorProfile sensor, localizing_sensor(input.options, /*earlier=*/nullptr));
  artifacts.provide(input.sensor, std::move(sensor));
  SIGHTLINE_ASSIGN(ForeignNds map, open_apollo_map(file, /*threads=*/0));
  SIGHTLINE_TRY(check_world("annotation.world", input.world, map.world, file));
  SIGHTLINE_TRY(check_world("route.world", input.route_options.world, map.world, file));
  SIGHTLINE_TRY(provide_route(input, map.world, artifacts));
  if (!input.options.name.empty()) map.name = input.options.name;
  const Digest digest = map.digest;
  artifacts.provide(input.nds, std::move(map), digest);
  return {};
}

// A finished map, its route, and the sensor that will localize in it.
Result<void> provide_finished(const CompilePlan& compile, ArtifactSet& artifacts) {
  const FinishedMapInput& input = compile.finished;
  if (input.compiled.is_connected()) return provide_compiled(input, artifacts);
  if (input.nds.is_connected()) return provide_nds(input, artifacts);
  if (!input.points.is_connected()) return {};
  // The route first: it is read in no time.
  SIGHTLINE_TRY(provide_route(input, input.route_options.world, artifacts));
  SIGHTLINE_ASSIGN(SensorProfile sensor, localizing_sensor(input.options, /*earlier=*/nullptr));
  artifacts.provide(input.sensor, std::move(sensor));
  SIGHTLINE_ASSIGN(PointMap map, open_point_map(input.options.points, /*threads=*/0));
  if (!input.options.name.empty()) map.name = input.options.name;
  const Digest digest = map.digest;
  artifacts.provide(input.points, std::move(map), digest);
  return {};
}

// Poses of an earlier map.
Result<void> provide_base(const CompilePlan& compile, ArtifactSet& artifacts) {
  if (!compile.base.is_connected()) return {};
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, read_file(compile.base_file));
  Result<ReleasedPoses> released = from_bytes<ReleasedPoses>(bytes);
  if (!released) return in_file(released.error(), compile.base_file);
  artifacts.provide(compile.base, std::move(*released));
  return {};
}

// A model file may be packed as one frame of zstd.
Result<std::vector<std::byte>> read_model_bytes(const std::filesystem::path& file) {
  SIGHTLINE_ASSIGN(std::vector<std::byte> bytes, read_file(file));
  const std::uint64_t raw_size = content_size(bytes);
  if (raw_size == 0) return bytes;
  Result<std::vector<std::byte>> unpacked = unpack_zstd(bytes, raw_size);
  if (!unpacked) return in_file(unpacked.error(), file.string());
  return unpacked;
}

}  // namespace

Result<void> provide_drive(const EvaluatePlan& evaluate,
                           const std::filesystem::path& cache_directory, ArtifactSet& artifacts) {
  SIGHTLINE_TRY(provide_recording(evaluate.recording, CachedDigests(cache_directory),
                                  new_scan_memory(), artifacts));
  const AnyWire recording = evaluate.recording.recording;
  const RecordingCard card{evaluate.recording.role,
                           artifacts.get(evaluate.recording.recording).name,
                           artifacts.entry(recording).key};
  artifacts.provide(evaluate.cards, RecordingCards{{card}});
  return provide_outside(evaluate.outside, artifacts);
}

Result<void> provide_drives(const CompilePlan& compile,
                            const std::filesystem::path& cache_directory, ArtifactSet& artifacts) {
  const EmitMapOptions emit = compile.plan.options(kEmitMap);
  SIGHTLINE_TRY(check_options(emit));
  // The files that are read in no time come first: a mistake in them is reported at once.
  SIGHTLINE_TRY(provide_outside(compile.outside, artifacts));
  SIGHTLINE_TRY(provide_finished(compile, artifacts));
  SIGHTLINE_TRY(provide_base(compile, artifacts));
  const CachedDigests digests(cache_directory);
  const std::shared_ptr<ScanMemory> memory = new_scan_memory();
  for (const RecordingInput& input : compile.recordings) {
    SIGHTLINE_TRY(provide_recording(input, digests, memory, artifacts));
    if (emit.world == kLocalWorld) {
      SIGHTLINE_TRY(check_near(input, artifacts));
    }
  }
  SIGHTLINE_TRY(check_named_once(compile, artifacts));
  artifacts.provide(compile.cards, recording_cards(compile, artifacts));
  return {};
}

void provide_map(const CompiledMap& map, const EvaluatePlan& evaluate, ArtifactSet& artifacts) {
  artifacts.provide(evaluate.ndt, map.ndt);
  artifacts.provide(evaluate.sites, map.sites);
  artifacts.provide(evaluate.predicted, predicted_of(map));
  artifacts.provide(evaluate.ranges, choice_of(map));
  artifacts.provide(evaluate.factors, factors_of(map));
}

RecordingCards recording_cards(const CompilePlan& compile, const ArtifactSet& artifacts) {
  RecordingCards recordings;
  const auto add = [&](const std::string& role, AnyWire wire, const std::string& name) {
    recordings.cards.push_back({role, name, artifacts.entry(wire).key});
  };
  const auto file_name = [](const std::string& file) {
    return std::filesystem::path(file).filename().string();
  };
  const FinishedMapInput& finished = compile.finished;
  if (artifacts.has(finished.points)) {
    add("map", finished.points, artifacts.get(finished.points).name);
  }
  if (artifacts.has(finished.nds)) add("map", finished.nds, artifacts.get(finished.nds).name);
  if (artifacts.has(finished.compiled)) {
    const MapOptions& options = finished.options;
    add("map", finished.compiled, options.name.empty() ? file_name(options.points) : options.name);
  }
  if (artifacts.has(compile.base)) add("base", compile.base, file_name(compile.base_file));
  for (const RecordingInput& input : compile.recordings) {
    if (!artifacts.has(input.recording)) continue;
    add(input.role, input.recording, artifacts.get(input.recording).name);
  }
  return recordings;
}

namespace {

// A promise of errors in full maps is none for a map whose NDs are fewer and rounded.
Result<void> check_size_of_maps(const CompilePlan& compile, const TrainingCard& card,
                                const std::filesystem::path& file) {
  const bool is_small = compile.plan.options(kEmitMap).size == MapSize::kPromise;
  const std::vector<std::string> ours = localizer_names();
  const bool is_ours = std::ranges::find(ours, card.localizer.name) != ours.end();
  if (!is_ours || is_small == was_in_small_map(card.localizer)) return {};
  return Error{ErrorCode::kMismatchedInputs,
               is_small ? "the model was trained on full maps, and this map is small: train it "
                          "with --set emit-map.size=promise, or leave emit-map.size out"
                        : "the model was trained on small maps, and this map is full: set "
                          "emit-map.size=promise, or train it without",
               file.string()};
}

}  // namespace

Result<void> provide_model(const CompilePlan& compile, const std::filesystem::path& file,
                           ArtifactSet& artifacts) {
  if (file.empty()) return {};
  SIGHTLINE_ASSIGN(ByFamily<ErrorModel> model, read_model(file));
  SIGHTLINE_TRY(check_size_of_maps(compile, model.ranges.card, file));
  artifacts.provide(compile.given_model, std::move(model));
  return {};
}

Result<ByFamily<ErrorModel>> read_model(const std::filesystem::path& file) {
  Result<ByFamily<ErrorModel>> model = Error{ErrorCode::kCannotRead, "no model", file.string()};
  if (file.extension() == ".slmap") {
    SIGHTLINE_ASSIGN(const CompiledMap map, read_map(file));
    model = model_of(map.model);
  } else {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, read_model_bytes(file));
    model = from_bytes<ByFamily<ErrorModel>>(bytes);
  }
  if (!model) return in_file(model.error(), file.string());
  return model;
}

}  // namespace sightline
