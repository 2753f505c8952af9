#include "passes/map/places/free_ground.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"

// First every floor of the raster is a place. Then what stands between a floor and the vehicle's
// roof takes those away that it stands on, and with them all whose vehicle would touch it, and so
// does ground that is far from any that was seen. What is left falls into stretches.

namespace sightline {
namespace {

// From one place to another: kerbs and unevenness, and the steepest street.
constexpr double kMostStep_m = 0.15;
constexpr double kMostSlope = 0.3;
// What is lower a wheel goes over, or it is the ground itself.
constexpr double kOver_m = 0.3;
// Along ground that was not seen.
constexpr double kUnseen_m = 3.0;

// Columns that may have a floor: those with a level patch and their neighbours, ascending.
std::vector<CellKey> columns_near(const GroundFloors& floors) {
  CellIndex near;
  for (const CellKey& column : floors.columns()) {
    for (int code = 0; code < 9; ++code) {
      near.add({column.x + code % 3 - 1, column.y + code / 3 - 1, 0});
    }
  }
  std::vector<CellKey> columns = near.keys();
  std::ranges::sort(columns);
  return columns;
}

// Raster places along one axis of a column.
struct Steps {
  std::int32_t begin = 0;
  std::int32_t end = 0;
};

Steps steps_of(std::int32_t column, double step_m) {
  const auto first_from = [&](std::int32_t face) {
    return static_cast<std::int32_t>(std::ceil(face * GroundFloors::kColumn_m / step_m));
  };
  return {first_from(column), first_from(column + 1)};
}

// Every floor over columns of one x.
std::vector<GroundPlace> floors_over(std::span<const CellKey> columns, const GroundFloors& floors,
                                     double step_m) {
  std::vector<GroundPlace> places;
  const Steps along_x = steps_of(columns.front().x, step_m);
  for (std::int32_t x = along_x.begin; x < along_x.end; ++x) {
    for (const CellKey& column : columns) {
      const Steps along_y = steps_of(column.y, step_m);
      for (std::int32_t y = along_y.begin; y < along_y.end; ++y) {
        for (const double ground_m : floors.at({x * step_m, y * step_m})) {
          places.push_back({x, y, ground_m});
        }
      }
    }
  }
  return places;
}

// Ascending by (x, y, ground_m).
std::vector<GroundPlace> all_floors(const GroundFloors& floors, double step_m, int threads) {
  const std::vector<CellKey> columns = columns_near(floors);
  std::vector<std::span<const CellKey>> strips;
  for (std::size_t first = 0; first < columns.size();) {
    std::size_t end = first;
    while (end < columns.size() && columns[end].x == columns[first].x) ++end;
    strips.push_back(std::span(columns).subspan(first, end - first));
    first = end;
  }
  std::vector<GroundPlace> places;
  for (const std::vector<GroundPlace>& strip : parallel_map<std::vector<GroundPlace>>(
           strips.size(), threads,
           [&](std::size_t i) { return floors_over(strips[i], floors, step_m); })) {
    places.insert(places.end(), strip.begin(), strip.end());
  }
  return places;
}

// Raster places that a vehicle covers however it is turned, from its own; a step away at least.
std::vector<CellKey> footprint(double width_m, double step_m) {
  const double radius = 0.5 * width_m / step_m + 1e-9;
  const auto reach = static_cast<std::int32_t>(std::max(1.0, std::floor(radius)));
  std::vector<CellKey> offsets;
  for (std::int32_t x = -reach; x <= reach; ++x) {
    for (std::int32_t y = -reach; y <= reach; ++y) {
      if (portable_hypot(x, y) <= std::max(1.0, radius)) offsets.push_back({x, y, 0});
    }
  }
  return offsets;
}

}  // namespace

Result<FreeGround> FreeGround::over(const TiledSurface& surface, const GroundFloors& floors,
                                    double step_m, const VehicleRoom& room, int threads) {
  FreeGround free;
  free.step_m_ = step_m;
  free.places_ = all_floors(floors, step_m, threads);
  free.index();
  std::vector<std::uint8_t> is_obstructed(free.places_.size(), 0);
  for (const RowTile& place : surface.tiles()) {
    SIGHTLINE_ASSIGN(const Surface tile, surface.tile(place));
    free.add_obstructed(tile, room.height_m, is_obstructed);
  }
  free.keep_free(is_obstructed, room.width_m, threads);
  free.keep_near_seen(floors);
  free.find_stretches();
  return free;
}

void FreeGround::index() {
  first_.clear();
  first_.reserve(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    first_.insert({places_[i].x, places_[i].y, 0}, static_cast<std::uint32_t>(i));
  }
}

bool FreeGround::goes_on(const GroundPlace& from, const GroundPlace& to) const {
  const double way_m = step_m_ * portable_hypot(to.x - from.x, to.y - from.y);
  return std::abs(to.ground_m - from.ground_m) <= kMostStep_m + kMostSlope * way_m;
}

// Calls use(place) for each that the ground goes on to, a step along x or y.
template <class Use>
void FreeGround::visit_around(std::uint32_t place, const Use& use) const {
  constexpr std::array<std::array<std::int32_t, 2>, 4> kAround = {
      {{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const GroundPlace& at = places_[place];
  for (const auto& [dx, dy] : kAround) {
    const std::uint32_t to = next(at, at.x + dx, at.y + dy);
    if (to != kNone) use(to);
  }
}

std::uint32_t FreeGround::next(const GroundPlace& from, std::int32_t x, std::int32_t y) const {
  const std::uint32_t* const first = first_.find({x, y, 0});
  if (first == nullptr) return kNone;
  std::uint32_t best = *first;
  for (std::uint32_t i = best; i < places_.size() && places_[i].x == x && places_[i].y == y; ++i) {
    const double off_m = std::abs(places_[i].ground_m - from.ground_m);
    if (off_m < std::abs(places_[best].ground_m - from.ground_m)) best = i;
  }
  return goes_on(from, places_[best]) ? best : kNone;
}

// Where something solid is above a floor and below the roof of a vehicle on it.
void FreeGround::add_obstructed(const Surface& tile, double height_m,
                                std::vector<std::uint8_t>& is_obstructed) const {
  const auto stand = [&](const Eigen::Vector3d& solid_m) {
    const auto x = static_cast<std::int32_t>(std::lround(solid_m.x() / step_m_));
    const auto y = static_cast<std::int32_t>(std::lround(solid_m.y() / step_m_));
    const std::uint32_t* const first = first_.find({x, y, 0});
    if (first == nullptr) return;
    std::uint32_t below = kNone;
    for (std::uint32_t i = *first; i < places_.size() && places_[i].x == x && places_[i].y == y;
         ++i) {
      if (places_[i].ground_m <= solid_m.z()) below = i;
    }
    if (below == kNone) return;
    const double above_m = solid_m.z() - places_[below].ground_m;
    if (above_m > kOver_m && above_m < height_m) is_obstructed[below] = 1;
  };
  for (const SurfacePatch& patch : tile.patches) {
    const double square_m = 2.0 * patch.half_side_m / kPatchSquares;
    visit_solid_squares(patch, static_cast<int>(std::ceil(square_m / step_m_)), stand);
  }
}

void FreeGround::keep_free(const std::vector<std::uint8_t>& is_obstructed, double width_m,
                           int threads) {
  const std::vector<CellKey> offsets = footprint(width_m, step_m_);
  std::vector<std::uint8_t> is_free(places_.size(), 0);
  parallel_for(places_.size(), threads, [&](std::size_t i) {
    is_free[i] = std::ranges::all_of(offsets, [&](const CellKey& offset) {
      const std::uint32_t at = next(places_[i], places_[i].x + offset.x, places_[i].y + offset.y);
      return at != kNone && is_obstructed[at] == 0;
    });
  });
  keep(is_free);
}

void FreeGround::keep(const std::vector<std::uint8_t>& is_kept) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (is_kept[i] != 0) places_[kept++] = places_[i];
  }
  places_.resize(kept);
  index();
}

// Extrapolated ground goes on behind walls too: there is no way far along it.
void FreeGround::keep_near_seen(const GroundFloors& floors) {
  std::vector<std::uint8_t> is_near(places_.size(), 0);
  std::vector<std::uint32_t> reached;
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    const GroundPlace& place = places_[i];
    if (!floors.is_seen({place.x * step_m_, place.y * step_m_}, place.ground_m)) continue;
    is_near[i] = 1;
    reached.push_back(i);
  }
  for (auto steps = static_cast<int>(kUnseen_m / step_m_); steps > 0; --steps) {
    std::vector<std::uint32_t> further;
    for (const std::uint32_t i : reached) {
      visit_around(i, [&](std::uint32_t to) {
        if (is_near[to] != 0) return;
        is_near[to] = 1;
        further.push_back(to);
      });
    }
    reached = std::move(further);
  }
  keep(is_near);
}

void FreeGround::find_stretches() {
  stretches_.assign(places_.size(), kNone);
  std::vector<std::uint32_t> open;
  for (std::uint32_t first = 0; first < places_.size(); ++first) {
    if (stretches_[first] != kNone) continue;
    const auto stretch = static_cast<std::uint32_t>(stretch_sizes_.size());
    stretch_sizes_.push_back(0);
    stretches_[first] = stretch;
    open = {first};
    while (!open.empty()) {
      const std::uint32_t at = open.back();
      open.pop_back();
      ++stretch_sizes_.back();
      visit_around(at, [&](std::uint32_t to) {
        if (stretches_[to] != kNone) return;
        stretches_[to] = stretch;
        open.push_back(to);
      });
    }
  }
}

}  // namespace sightline
