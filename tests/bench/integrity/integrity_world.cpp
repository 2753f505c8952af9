#include "tests/bench/integrity/integrity_world.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "examples/town/drive/drive.h"
#include "formats/base/parallel.h"
#include "tests/bench/mapped_town.h"

namespace sightline {
namespace {

std::string kind_at(const town::Town& town, double s_m) {
  if (!town.is_hard()) return "streets";
  return std::string(town::place_kind_name(town::place_at(town.places, s_m).kind));
}

// Of the scans nearest to those that are examined. Streets constrain every direction.
std::vector<town::Constraint> constraints_of(const town::Town& town,
                                             const town::DriveSimulator& drive,
                                             const IntegrityWorldOptions& options) {
  std::vector<town::Constraint> all(drive.scan_count());
  if (!town.is_hard()) return all;
  std::vector<std::size_t> examined;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const double before_m = examined.empty() ? -1e9 : drive.driven_m(examined.back());
    if (drive.driven_m(i) - before_m >= options.constraints_every_m) examined.push_back(i);
  }
  const std::vector<town::Constraint> found = parallel_map<town::Constraint>(
      examined.size(), options.threads,
      [&](std::size_t i) { return town::constraint_of(drive, examined[i]); });
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < examined.size(); ++k) {
      const auto away = [&](std::size_t n) {
        return std::abs(drive.driven_m(examined[n]) - drive.driven_m(i));
      };
      if (away(k) < away(nearest)) nearest = k;
    }
    all[i] = found[nearest];
  }
  return all;
}

}  // namespace

Result<IntegrityWorld> make_integrity_world(const IntegrityWorldOptions& options) {
  MappedTownOptions making;
  making.town.seed = options.seed;
  making.town.length_m = options.length_m;
  if (options.world != "town-streets") {
    const std::optional<town::WorldKind> kind = town::world_kind(options.world);
    if (!kind) return Error{ErrorCode::kUnknownName, "no such world", options.world};
    making.town.world = *kind;
  }
  making.beams = options.beams;
  making.threads = options.threads;
  MappedTown mapped = make_mapped_town(making);
  IntegrityWorld world{options.world, options.seed, std::move(mapped.map), mapped.sensor, {}};
  SIGHTLINE_ASSIGN(const town::Town town, town::make_town(making.town));
  for (const std::uint64_t number : options.drives) {
    SIGHTLINE_ASSIGN(
        const town::DriveSimulator drive,
        town::DriveSimulator::make(town, town::usual_drive(making.town, number, mapped.sensor)));
    TownDrive scans = number == 2
                          ? TownDrive{std::move(mapped.scans), std::move(mapped.T_map_vehicle)}
                          : drive_through_town(making, number, mapped.sensor);
    TrueDrive& driven = world.drives.emplace_back();
    driven.scans = std::move(scans.scans);
    driven.T_map_vehicle = std::move(scans.T_map_vehicle);
    driven.constraints = constraints_of(town, drive, options);
    for (std::size_t i = 0; i < driven.scans.size(); ++i) {
      driven.kinds.push_back(kind_at(town, drive.driven_m(i)));
    }
  }
  return world;
}

}  // namespace sightline
