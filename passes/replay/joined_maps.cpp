#include "passes/replay/joined_maps.h"

#include <limits>
#include <utility>

#include "formats/reader/map_layout.h"
#include "passes/replay/pose_rows.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string world_text(const std::string& file, std::string_view world) {
  return world == kLocalWorld ? concat(file, " is in no world (local)")
                              : concat(file, " is in the world ", world);
}

// The library returns the whole text of an error as its message.
Error without_code(const Error& error) {
  const std::string code = to_string(Error{error.code, "", "", ""});
  if (!error.message.starts_with(code)) return error;
  return Error{error.code, error.message.substr(code.size()), "", ""};
}

}  // namespace

Result<VehicleLocalizer> JoinedMaps::localizer_of(const Entry& entry, bool is_whole) const {
  sightline_localizer_options options{};
  options.holds_whole_map = is_whole ? 1 : 0;  // places are checked by its NDs
  options.has_no_thread = is_whole ? 0 : 1;
  options.threads = options_.threads;
  options.azimuth_step_deg = options_.azimuth_step_deg.value_or(0.0);
  PoseRows T_vehicle_sensor{};
  if (options_.T_vehicle_sensor) {
    T_vehicle_sensor = rows_of(*options_.T_vehicle_sensor);
    options.T_vehicle_sensor = T_vehicle_sensor.data();
  }
  Result<VehicleLocalizer> localizer = VehicleLocalizer::open(entry.file, options);
  if (!localizer) return without_code(localizer.error());
  return localizer;
}

// For the localizer of this program, if the errors of the map are those of one.
Result<void> JoinedMaps::add(Entry& entry) {
  SIGHTLINE_ASSIGN(const VehicleLocalizer localizer, localizer_of(entry, false));
  const sightline_localizer_info info = localizer.info();
  SIGHTLINE_ASSIGN(MapReader reader, MapReader::open(entry.file, info.localizer));
  entry.reader.emplace(std::move(reader));
  if (!options_.T_vehicle_sensor) options_.T_vehicle_sensor = pose_of(info.T_vehicle_sensor);
  return {};
}

Result<void> JoinedMaps::check_worlds() const {
  const Entry* first = nullptr;
  for (const Entry& entry : maps_) {
    if (!entry.reader) continue;
    if (first == nullptr) {
      first = &entry;
      continue;
    }
    const std::string_view world = entry.reader->info().world;
    const std::string_view first_world = first->reader->info().world;
    if (world == first_world && world != kLocalWorld) continue;
    return Error{ErrorCode::kMismatchedInputs,
                 concat("maps are joined by their world: ", world_text(first->file, first_world),
                        ", ", world_text(entry.file, world),
                        ". Compile all of them with the same annotation.world"),
                 entry.file};
  }
  return {};
}

Result<JoinedMaps> JoinedMaps::open(const std::vector<std::string>& files,
                                    const JoinedMapsOptions& options) {
  JoinedMaps joined(options);
  for (const std::string& file : files) {
    Entry& entry = joined.maps_.emplace_back();
    entry.file = file;
    const Result<void> added = joined.add(entry);
    if (!added) entry.fault = added.error();
  }
  while (joined.maps_[joined.present_].fault) {
    if (++joined.present_ == files.size()) return *joined.maps_.front().fault;
  }
  SIGHTLINE_TRY(joined.check_worlds());
  joined.before_ = joined.present_;
  return joined;
}

// Infinite where the map has no site within its reach, or a fault.
double JoinedMaps::distance_m(Entry& entry, const Eigen::Vector3d& sensor_world_m) {
  if (entry.fault) return kInfinity;
  const MapReader& reader = *entry.reader;
  const Result<RangeAnswer> answer = reader.observation_range(
      {sensor_world_m.x(), sensor_world_m.y(), sensor_world_m.z()}, reader.info().limits_m.front());
  if (answer) return answer->distance_m;
  entry.fault = in_file(answer.error(), entry.file);
  return kInfinity;
}

// None where no map has a site within its reach. The first of several.
std::optional<std::size_t> JoinedMaps::nearest(const Eigen::Vector3d& sensor_world_m) {
  std::optional<std::size_t> best;
  double best_m = kInfinity;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    const double at_m = distance_m(maps_[i], sensor_world_m);
    if (at_m >= best_m) continue;
    best = i;
    best_m = at_m;
  }
  return best;
}

Result<void> JoinedMaps::go_to(std::size_t map) {
  Entry& entry = maps_[map];
  if (entry.fault) return *entry.fault;
  if (!entry.in_memory) {
    if (before_ != present_) maps_[before_].in_memory.reset();
    Result<VehicleLocalizer> localizer = localizer_of(entry, true);
    if (!localizer) {
      entry.fault = localizer.error();
      return *entry.fault;
    }
    entry.in_memory = std::make_unique<MapInMemory>(*std::move(localizer));
  }
  if (map != present_) before_ = std::exchange(present_, map);
  return {};
}

Result<void> JoinedMaps::go_to(const Eigen::Vector3d& sensor_world_m, bool is_tracking) {
  if (is_tracking && distance_m(maps_[present_], sensor_world_m) < kInfinity) return stay();
  for (std::optional<std::size_t> next = nearest(sensor_world_m); next;
       next = nearest(sensor_world_m)) {
    if (go_to(*next)) return {};
  }
  return stay();
}

Result<void> JoinedMaps::stay() {
  for (std::size_t i = 0; i < count(); ++i) {
    if (go_to((present_ + i) % count())) return {};
  }
  return *maps_.front().fault;
}

}  // namespace sightline
