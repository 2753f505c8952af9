#include "passes/map/places/choose_route_sites.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>

#include "formats/grid/point_grid.h"
#include "passes/map/places/ground_floors.h"

namespace sightline {
namespace {

constexpr double kOffMap_m = 20.0;       // without any surface so near
constexpr double kOffGround_m = 3.0;     // of a height that the route has
constexpr double kLongestHole_m = 10.0;  // in the ground, that is bridged
// From one place to the next, the steepest street and unevenness.
constexpr double kMostSlope = 0.3;
constexpr double kMostStep_m = 0.3;
constexpr double kRounding_m = 1e-9;

enum class Fate { kKept, kOffMap, kNoGround, kOffGround, kTwoFloors };
constexpr std::size_t kFateCount = 5;

// A place of a line, before it becomes a site.
struct Place {
  double s_m = 0.0;
  Eigen::Vector3d at_map_m = Eigen::Vector3d::Zero();  // z: that of the line, else 0
  Eigen::Vector2d heading = Eigen::Vector2d::UnitX();  // of unit length
  std::vector<double> floors_m;
  std::optional<double> ground_m;
  Fate fate = Fate::kKept;
};

// A line in the map's frame, followed in one direction.
struct Way {
  const RouteLine& line;
  std::vector<Eigen::Vector3d> points_m;
};

// Every spacing_m of arc length: of the plane where the line has no heights.
std::vector<Place> places_of(const Way& way, double spacing_m) {
  std::vector<Place> places;
  double begin_m = 0.0;
  for (std::size_t i = 1; i < way.points_m.size(); ++i) {
    const Eigen::Vector3d step_m = way.points_m[i] - way.points_m[i - 1];
    const double length_m = step_m.norm();
    const double level_m = step_m.head<2>().norm();
    if (level_m == 0.0) {
      begin_m += length_m;
      continue;
    }
    double s_m = static_cast<double>(places.size()) * spacing_m;
    while (s_m <= begin_m + length_m + kRounding_m) {
      Place& place = places.emplace_back();
      place.s_m = s_m;
      const double share = std::clamp((s_m - begin_m) / length_m, 0.0, 1.0);
      place.at_map_m = way.points_m[i - 1] + share * step_m;
      place.heading = step_m.head<2>() / level_m;
      s_m = static_cast<double>(places.size()) * spacing_m;
    }
    begin_m += length_m;
  }
  return places;
}

// What a place is laid on.
struct Ground {
  const GroundFloors& floors;
  const PointGrid& patches;  // in the plane
  double vehicle_m = 0.0;    // height of the vehicle's origin above ground
};

// By the height of the line, where it has one.
void lay_by_height(const Way& way, const Ground& ground, Place& place) {
  if (place.fate != Fate::kKept) return;
  const bool is_vehicle = way.line.heights == RouteHeights::kVehicle;
  const double told_m = place.at_map_m.z() - (is_vehicle ? ground.vehicle_m : 0.0);
  if (place.floors_m.empty()) {
    if (is_vehicle) place.ground_m = told_m;
    return;
  }
  const auto nearest = std::ranges::min_element(
      place.floors_m, {}, [&](double floor_m) { return std::abs(floor_m - told_m); });
  if (std::abs(*nearest - told_m) > kOffGround_m) {
    place.fate = Fate::kOffGround;
    return;
  }
  place.ground_m = is_vehicle ? told_m : *nearest;
}

// The floor that goes on from a neighbour whose floor is known.
std::optional<double> continued(const Place& place, const Place& neighbour) {
  const double most_m =
      kMostStep_m + kMostSlope * (place.at_map_m - neighbour.at_map_m).head<2>().norm();
  const auto nearest = std::ranges::min_element(
      place.floors_m, {}, [&](double floor_m) { return std::abs(floor_m - *neighbour.ground_m); });
  const bool goes_on =
      nearest != place.floors_m.end() && std::abs(*nearest - *neighbour.ground_m) <= most_m;
  return goes_on ? std::optional(*nearest) : std::nullopt;
}

// One floor is taken; of several that which goes on along the line, forwards, then backwards.
void lay_by_continuity(std::vector<Place>& places) {
  for (Place& place : places) {
    if (place.fate == Fate::kKept && place.floors_m.size() == 1) {
      place.ground_m = place.floors_m.front();
    }
  }
  const auto carry_on = [](const Place& from, Place& to) {
    if (!from.ground_m || to.ground_m || to.fate != Fate::kKept) return;
    to.ground_m = continued(to, from);
  };
  for (std::size_t i = 1; i < places.size(); ++i) carry_on(places[i - 1], places[i]);
  for (std::size_t i = places.size(); i-- > 1;) carry_on(places[i], places[i - 1]);
}

// Short holes between ground and ground.
void bridge_holes(std::vector<Place>& places) {
  const auto is_hole = [](const Place& place) {
    return place.fate == Fate::kKept && !place.ground_m && place.floors_m.empty();
  };
  for (std::size_t i = 1; i < places.size(); ++i) {
    if (!is_hole(places[i]) || !places[i - 1].ground_m) continue;
    std::size_t end = i;
    while (end < places.size() && is_hole(places[end])) ++end;
    if (end == places.size() || !places[end].ground_m) continue;
    const Place& before = places[i - 1];
    const double length_m = places[end].s_m - before.s_m;
    if (length_m > kLongestHole_m) continue;
    const double rise_m = *places[end].ground_m - *before.ground_m;
    for (std::size_t k = i; k < end; ++k) {
      places[k].ground_m = *before.ground_m + (places[k].s_m - before.s_m) / length_m * rise_m;
    }
  }
}

// Of ground that was seen: extrapolated ground reaches far over holes.
std::vector<double> seen_floors(const GroundFloors& floors, const Eigen::Vector2d& at_m) {
  std::vector<double> seen_m = floors.at(at_m);
  std::erase_if(seen_m, [&](double floor_m) { return !floors.is_seen_around(at_m, floor_m); });
  return seen_m;
}

std::vector<Place> laid_places(const Way& way, double spacing_m, const Ground& ground) {
  std::vector<Place> places = places_of(way, spacing_m);
  for (Place& place : places) {
    const Eigen::Vector3d level_m(place.at_map_m.x(), place.at_map_m.y(), 0.0);
    if (!ground.patches.nearest(level_m, kOffMap_m)) place.fate = Fate::kOffMap;
    if (place.fate == Fate::kKept) place.floors_m = seen_floors(ground.floors, level_m.head<2>());
  }
  if (way.line.heights == RouteHeights::kNone) {
    lay_by_continuity(places);
  } else {
    for (Place& place : places) lay_by_height(way, ground, place);
  }
  bridge_holes(places);
  for (Place& place : places) {
    if (place.fate != Fate::kKept || place.ground_m) continue;
    place.fate = place.floors_m.empty() ? Fate::kNoGround : Fate::kTwoFloors;
  }
  return places;
}

// What became of all places, and the first of each fate.
struct Tally {
  std::array<std::size_t, kFateCount> counts{};
  std::array<std::string, kFateCount> first;
  std::size_t total = 0;

  void add(const Place& place, const RouteLine& line) {
    const auto fate = static_cast<std::size_t>(place.fate);
    ++total;
    if (counts[fate]++ > 0) return;
    char at[64];
    std::snprintf(at, sizeof at, " at %.0f m", place.s_m);
    first[fate] = line.name + at;
  }
  [[nodiscard]] std::size_t count(Fate fate) const {
    return counts[static_cast<std::size_t>(fate)];
  }
};

void append_sites(const std::vector<Place>& places, const Ground& ground,
                  const SensorProfile& sensor, Sites& sites) {
  std::uint32_t run = sites.sites.empty() ? 0 : sites.sites.back().run + 1;
  std::size_t first = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].fate != Fate::kKept) {
      if (i > first) ++run;
      first = i + 1;
      continue;
    }
    const double s_m = static_cast<double>(i - first) * sites.spacing_m;
    const Eigen::Vector3d vehicle_m(places[i].at_map_m.x(), places[i].at_map_m.y(),
                                    *places[i].ground_m + ground.vehicle_m);
    sites.sites.push_back(level_site(run, s_m, vehicle_m, places[i].heading, sensor));
  }
}

constexpr std::array<const char*, kFateCount> kReasons = {
    "", "off the map", "without ground in the map", "more than 3 m from any ground of the map",
    "on one of several floors, and the route has no heights"};

void warn_of_left_out(const PassContext& ctx, const Route& route, const Tally& tally) {
  for (std::size_t fate = 1; fate < kFateCount; ++fate) {
    if (tally.counts[fate] == 0) continue;
    ctx.warn(concat(tally.counts[fate], " of ", tally.total, " places of route ", route.name,
                    " were left out: ", kReasons[fate], ". The first is on ", tally.first[fate]));
  }
}

std::string metres(double length_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f m", length_m);
  return text;
}

// Where no place was kept.
Error nowhere(const Route& route, const Tally& tally, const PointGrid& patches,
              const Eigen::Vector3d& first_map_m) {
  const std::string all = concat("none of the ", tally.total, " places of route ", route.name);
  const char* const place = "pass choose-route-sites";
  const std::size_t off_map = tally.count(Fate::kOffMap);
  if (off_map == tally.total) {
    const std::optional<NearPoint> nearest =
        patches.nearest(first_map_m, std::numeric_limits<double>::infinity());
    return {ErrorCode::kNoOverlap,
            concat(all, " is on the map; the first is ",
                   (nearest ? metres(nearest->distance_m) : "nowhere"),
                   " away from it. Give both in the same coordinates (route.world)"),
            "", place};
  }
  if (tally.count(Fate::kTwoFloors) >
      tally.count(Fate::kNoGround) + tally.count(Fate::kOffGround)) {
    return {
        ErrorCode::kTwoFloors,
        all +
            " is on a floor that can be determined: the map has several. Add heights to the route",
        "", place};
  }
  return {
      ErrorCode::kNoGround,
      concat(all, " is on the ground: ", tally.count(Fate::kNoGround), " have no ground below, ",
             tally.count(Fate::kOffGround), " are more than 3 m from it"),
      "", place};
}

}  // namespace

std::vector<OptionField> option_fields(ChooseRouteSitesOptions& options) {
  return {number("spacing_m", options.spacing_m, "distance between sites along the route, m", 0.1,
                 100.0)};
}

Result<Sites> choose_route_sites(PassContext& ctx, const ChooseRouteSitesOptions& options,
                                 const Route& route, const TiledSurface& surface,
                                 const SensorProfile& sensor) {
  for (const std::string& warning : route.warnings) ctx.warn(warning);
  GroundFloors floors;
  std::vector<Eigen::Vector3d> level_m;
  for (const RowTile& place : surface.tiles()) {
    SIGHTLINE_ASSIGN(const Surface tile, surface.tile(place));
    floors.add(tile);
    for (const SurfacePatch& patch : tile.patches) {
      level_m.emplace_back(patch.centre_m.x(), patch.centre_m.y(), 0.0);
    }
  }
  const PointGrid patches(level_m, kOffMap_m);
  const Ground ground{floors, patches, vehicle_above_ground_m(sensor)};
  Sites sites;
  sites.frame = surface.head().frame;
  sites.spacing_m = options.spacing_m;
  Tally tally;
  for (std::size_t i = 0; i < route.lines.size(); ++i) {
    const RouteLine& line = route.lines[i];
    Way way{line, line.points_world_m};
    for (Eigen::Vector3d& point_m : way.points_m) {
      point_m -= surface.head().frame.origin_world_m;
      if (line.heights == RouteHeights::kNone) point_m.z() = 0.0;
    }
    for (int direction = 0; direction < (line.is_both_ways ? 2 : 1); ++direction) {
      const std::vector<Place> places = laid_places(way, options.spacing_m, ground);
      for (const Place& place : places) tally.add(place, line);
      append_sites(places, ground, sensor, sites);
      std::ranges::reverse(way.points_m);
    }
    ctx.progress(i + 1, route.lines.size());
  }
  if (sites.sites.empty()) {
    Eigen::Vector3d first_m = route.lines.front().points_world_m.front();
    first_m -= surface.head().frame.origin_world_m;
    first_m.z() = 0.0;
    return nowhere(route, tally, patches, first_m);
  }
  warn_of_left_out(ctx, route, tally);
  return sites;
}

}  // namespace sightline
