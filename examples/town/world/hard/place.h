#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

// The kinds of places that a world is made of; see road.h for its coordinates.

namespace sightline::town {

enum class PlaceKind {
  kTown,          // houses, poles and parked cars: every direction is constrained
  kTunnel,        // lamps and niches at equal spacing, or smooth
  kMotorway,      // guard rails and posts at equal spacing, or smooth walls; lorries beside it
  kNoiseBarrier,  // walls with pillars at equal spacing, or smooth; lorries
  kField,         // one pole in 40 m
  kForest,        // trunks
  kBridge,        // railings, or smooth parapets; the ground is 15 m below
  kCarPark,       // storeys 2.75 m apart, ramps; half of the cars change between drives
  kPlaza,         // open, with few poles and benches
  kHills,         // slopes of 4 %
};
inline constexpr int kPlaceKinds = 10;
std::string_view place_kind_name(PlaceKind kind);  // "town", "noise-barrier", ...

// A part of the driven line, in arc length.
struct Place {
  PlaceKind kind = PlaceKind::kTown;
  double from_m = 0.0;
  double to_m = 0.0;

  [[nodiscard]] double length_m() const { return to_m - from_m; }
};

// The place at an arc length; the first or last one beyond the ends.
const Place& place_at(const std::vector<Place>& places, double s_m);

// What `--world` names: one kind, or all of them in random order. The town of streets that
// make_plan() lays out is no hard world.
struct WorldKind {
  bool is_hard = false;
  bool is_mixed = false;
  PlaceKind kind = PlaceKind::kTown;
};
std::optional<WorldKind> world_kind(std::string_view name);  // nullopt: no such world
std::string_view world_kind_name(const WorldKind& world);
std::vector<std::string_view> world_kind_names();

// The customary length of a world, m: 600 of a town of streets, 300 of one kind of place, 1280 of
// a mixed world (120 m each, and 40 m of town at both ends).
double usual_length_m(const WorldKind& world);

// The places of a world of that length, in order, without gaps. Unless it is bare it begins and
// ends with kEnd_m of town. Mixed worlds have as many places of about 120 m as the length holds:
// every kind once before any comes again, in an order by the seed.
inline constexpr double kEnd_m = 40.0;
struct WorldOrder {
  WorldKind world;
  bool is_bare = false;
  double length_m = 300.0;
};
std::vector<Place> order_places(std::uint64_t seed, const WorldOrder& order);

}  // namespace sightline::town
