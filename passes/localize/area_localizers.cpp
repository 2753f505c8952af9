#include "passes/localize/area_localizers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>
#include <vector>

#include "formats/base/parallel.h"
#include "passes/matching/localizer.h"

namespace sightline {
namespace {

constexpr double kArea_m = 64.0;  // edge
// Beyond its edges an area still serves. A drive that begins at the map's origin and goes straight
// follows an edge between two areas, and would have both made anew at each scan.
constexpr double kBeyond_m = 16.0;
// A match may start where another one ended; and a start is off by a metre or so. What is left is
// for the vehicle's extent.
constexpr double kMostStray_m = 2.0 * kFarthestFound_m + 4.0;

Eigen::AlignedBox2d box_of(const TileKey& area, double beyond_m) {
  const Eigen::Vector2d low_m(area.x * kArea_m, area.y * kArea_m);
  const Eigen::Vector2d high_m = low_m + Eigen::Vector2d::Constant(kArea_m);
  const Eigen::Vector2d beyond = Eigen::Vector2d::Constant(beyond_m);
  return {low_m - beyond, high_m + beyond};
}

// A match may start where another one ended; and more than the cells around a point, the start and
// the mounting.
constexpr double kStray_m = 2.0 * kFarthestFound_m + 16.0;

}  // namespace

AreaLocalizers::AreaLocalizers(const TiledNds& nds, const Options& options)
    : nds_(nds),
      options_(options),
      most_(static_cast<std::size_t>(threads_each(options.threads, 1))) {}

Result<AreaLocalizer> AreaLocalizers::make(const TileKey& area) const {
  const double reach_m =
      options_.longest_m + kMostStray_m + 2.0 * options_.coarse_cells * nds_.head().cell_m;
  SIGHTLINE_ASSIGN(NdtMap near, nds_.over(box_of(area, kBeyond_m + reach_m)));
  AreaLocalizer made;
  if (options_.kind == LocalizerKind::kPclNdt) {
    made.for_pcl = std::move(near);
    return made;
  }
  made.own = make_localizer(near, localizer_options(options_.kind, options_.coarse_cells));
  made.of_samples = localizer_for_samples(made.own, near, options_.coarse_cells);
  made.structures = StructureMap(near, made.own.levels.back().grid);
  return made;
}

Result<std::shared_ptr<const AreaLocalizer>> AreaLocalizers::at(const Eigen::Vector3d& p_map_m) {
  const std::shared_ptr<Place> place = place_of(p_map_m);
  // Threads that need another area continue meanwhile.
  const std::lock_guard<std::mutex> lock(place->mutex);
  if (!place->localizer) {
    SIGHTLINE_ASSIGN(AreaLocalizer made, make(place->area));
    place->localizer = std::make_shared<const AreaLocalizer>(std::move(made));
  }
  return place->localizer;
}

std::shared_ptr<AreaLocalizers::Place> AreaLocalizers::place_of(const Eigen::Vector3d& p_map_m) {
  const auto serves = [&](const std::shared_ptr<Place>& place) {
    return box_of(place->area, kBeyond_m).contains(p_map_m.head<2>());
  };
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = std::ranges::find_if(places_, serves);
  if (found != places_.end()) {
    places_.splice(places_.begin(), places_, found);
  } else {
    if (places_.size() >= most_) places_.pop_back();
    places_.push_front(std::make_shared<Place>());
    places_.front()->area = tile_key(p_map_m, kArea_m);
  }
  return places_.front();
}

MatchContents::MatchContents(const Drive& drive, const Trajectory& trajectory, TileDigests nds,
                             double longest_m)
    : drive_(drive), trajectory_(trajectory), longest_m_(longest_m), nds_(std::move(nds)) {}

std::optional<Digest> MatchContents::of(std::span<const std::optional<std::size_t>> scans) const {
  ByteWriter writer;
  encode(drive_.sensor, writer);
  std::vector<Eigen::Vector3d> places_m;
  for (const std::optional<std::size_t>& scan : scans) {
    if (!scan) continue;
    const std::optional<Digest> identity = drive_.store->identity(*scan);
    if (!identity) return std::nullopt;
    const Pose& T_map_vehicle = trajectory_.poses[*scan].T_map_vehicle;
    writer.put(drive_.scans[*scan].recording_index);  // its seed
    writer.put_array(std::span<const std::uint8_t>(*identity));
    encode(T_map_vehicle, writer);
    places_m.push_back(T_map_vehicle.translation());
  }
  DigestBuilder builder;
  builder.add(writer.bytes());
  if (!places_m.empty()) {
    builder.add(nds_.within(box_around(places_m, longest_m_ + kStray_m)));
  }
  return builder.finish();
}

}  // namespace sightline
