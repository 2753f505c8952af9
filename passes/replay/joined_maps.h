#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/result.h"
#include "formats/geometry.h"
#include "passes/replay/place_check.h"
#include "passes/replay/place_finder.h"
#include "passes/vehicle/vehicle_localizer.h"

namespace sightline {

struct JoinedMapsOptions {
  std::optional<Pose> T_vehicle_sensor;    // none: that of the first map
  std::optional<double> azimuth_step_deg;  // of the sensor; none: that of each map
  int threads = 0;
};

// A map that is held in memory.
struct MapInMemory {
  explicit MapInMemory(VehicleLocalizer opened)
      : localizer(std::move(opened)), check(localizer.info()) {}
  VehicleLocalizer localizer;
  PlaceCheck check;
  std::optional<PlaceFinder> finder;  // made when it is first needed
};

// The maps of one world that a vehicle drives through ("Several maps" in schemas/definitions.md).
// One of them is the present one. At most two are in memory: the present one and the one before it.
class JoinedMaps {
 public:
  // A map that cannot be opened becomes a fault. Errors: the first fault, where no map is left;
  // mismatched-inputs (several maps, of different worlds or of no world).
  static Result<JoinedMaps> open(const std::vector<std::string>& files,
                                 const JoinedMapsOptions& options);

  // The map for a sensor there becomes the present one: the map of the nearest site. While
  // tracking, the present map stays as long as it has a site within its reach. It also stays where
  // no map has one. A map that cannot be read becomes a fault, and the others are used. Errors: the
  // first fault, where no map is left.
  Result<void> go_to(const Eigen::Vector3d& sensor_world_m, bool is_tracking);
  // That map becomes the present one. Error: it has a fault, which is kept.
  Result<void> go_to(std::size_t map);
  // Reads the present map, or the next one without a fault, if it is not in memory. Errors: as
  // above.
  Result<void> stay();

  [[nodiscard]] std::size_t count() const { return maps_.size(); }
  [[nodiscard]] std::size_t present() const { return present_; }
  [[nodiscard]] const std::string& file(std::size_t map) const { return maps_[map].file; }
  [[nodiscard]] const std::optional<Error>& fault(std::size_t map) const {
    return maps_[map].fault;
  }
  // Of a map that could be opened: it stays open.
  [[nodiscard]] const MapReader& reader(std::size_t map) const { return *maps_[map].reader; }
  // The present map. Valid until another one becomes the present one.
  [[nodiscard]] MapInMemory& in_memory() { return *maps_[present_].in_memory; }
  [[nodiscard]] const Pose& T_vehicle_sensor() const { return *options_.T_vehicle_sensor; }

 private:
  struct Entry {
    std::string file;
    std::optional<MapReader> reader;
    std::optional<Error> fault;
    std::unique_ptr<MapInMemory> in_memory;
  };
  explicit JoinedMaps(const JoinedMapsOptions& options) : options_(options) {}
  Result<void> add(Entry& entry);
  [[nodiscard]] Result<void> check_worlds() const;
  [[nodiscard]] Result<VehicleLocalizer> localizer_of(const Entry& entry, bool is_whole) const;
  double distance_m(Entry& entry, const Eigen::Vector3d& sensor_world_m);
  std::optional<std::size_t> nearest(const Eigen::Vector3d& sensor_world_m);

  JoinedMapsOptions options_;
  std::vector<Entry> maps_;
  std::size_t present_ = 0;
  std::size_t before_ = 0;  // the present one before it
};

}  // namespace sightline
