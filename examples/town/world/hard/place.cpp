#include "examples/town/world/hard/place.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "examples/town/world/plan_route.h"
#include "formats/base/random.h"

namespace sightline::town {
namespace {

constexpr std::array<std::string_view, kPlaceKinds> kNames = {
    "town",   "tunnel", "motorway", "noise-barrier", "field",
    "forest", "bridge", "car-park", "plaza",         "hills"};
constexpr std::string_view kMixed = "mixed";
constexpr double kPlace_m = 120.0;  // of each kind in a mixed world
constexpr std::uint64_t kOrderKey = 0x6f72646572ULL;

void add_place(std::vector<Place>& places, PlaceKind kind, double length_m) {
  const double from_m = places.empty() ? 0.0 : places.back().to_m;
  places.push_back({kind, from_m, from_m + length_m});
}

void add_mixed_places(std::vector<Place>& places, std::uint64_t seed, double length_m) {
  std::vector<PlaceKind> kinds;
  for (int i = 0; i < kPlaceKinds; ++i) kinds.push_back(static_cast<PlaceKind>(i));
  Deck<PlaceKind> deck(kinds);
  Random random(mix(seed, kOrderKey));
  const auto count = std::max(1, static_cast<int>(std::lround(length_m / kPlace_m)));
  for (int i = 0; i < count; ++i) add_place(places, deck.deal(random), length_m / count);
}

}  // namespace

std::string_view place_kind_name(PlaceKind kind) {
  return kNames.at(static_cast<std::size_t>(kind));
}

const Place& place_at(const std::vector<Place>& places, double s_m) {
  std::size_t i = 0;
  while (i + 1 < places.size() && s_m >= places[i].to_m) ++i;
  return places[i];
}

std::optional<WorldKind> world_kind(std::string_view name) {
  if (name == kMixed) return WorldKind{.is_hard = true, .is_mixed = true};
  const auto* const found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  const auto kind = static_cast<PlaceKind>(found - kNames.begin());
  return WorldKind{.is_hard = kind != PlaceKind::kTown, .kind = kind};
}

std::string_view world_kind_name(const WorldKind& world) {
  return world.is_mixed ? kMixed : place_kind_name(world.kind);
}

std::vector<std::string_view> world_kind_names() {
  std::vector<std::string_view> names(kNames.begin(), kNames.end());
  names.push_back(kMixed);
  return names;
}

double usual_length_m(const WorldKind& world) {
  if (world.is_mixed) return 2.0 * kEnd_m + kPlaceKinds * kPlace_m;
  return world.is_hard ? 300.0 : 600.0;
}

std::vector<Place> order_places(std::uint64_t seed, const WorldOrder& order) {
  std::vector<Place> places;
  const double end_m = order.is_bare ? 0.0 : kEnd_m;
  if (!order.is_bare) add_place(places, PlaceKind::kTown, end_m);
  const double middle_m = order.length_m - 2.0 * end_m;
  if (order.world.is_mixed) {
    add_mixed_places(places, seed, middle_m);
  } else {
    add_place(places, order.world.kind, middle_m);
  }
  if (!order.is_bare) add_place(places, PlaceKind::kTown, end_m);
  return places;
}

}  // namespace sightline::town
