#include "examples/town/world/hard/hard_world.h"

#include "examples/town/world/hard/places.h"

namespace sightline::town {
namespace {

constexpr double kBeyond_m = 110.0;  // as far as a sensor sees
constexpr std::uint64_t kPlaceKey = 0x706c616365ULL;
constexpr std::uint64_t kCarsKey = 0x63617273ULL;

// The places, and what is beyond both ends of the line: more of the same, but a field around a car
// park, and the banks of a bridge.
std::vector<Place> built_places(const std::vector<Place>& places) {
  const auto ends_there = [](PlaceKind kind) {
    return kind == PlaceKind::kCarPark || kind == PlaceKind::kBridge || kind == PlaceKind::kHills;
  };
  std::vector<Place> built = places;
  const double end_m = places.back().to_m;
  if (ends_there(places.front().kind)) {
    built.insert(built.begin(), {PlaceKind::kField, -kBeyond_m, 0.0});
  } else {
    built.front().from_m = -kBeyond_m;
  }
  if (ends_there(places.back().kind)) {
    built.push_back({PlaceKind::kField, end_m, end_m + kBeyond_m});
  } else {
    built.back().to_m = end_m + kBeyond_m;
  }
  return built;
}

void add_place(TownMesh& mesh, const Road& road, const Place& place, const Random& random) {
  switch (place.kind) {
    case PlaceKind::kTown:
      return add_street(mesh, road, place, random);
    case PlaceKind::kTunnel:
      return add_tunnel(mesh, road, place, random);
    case PlaceKind::kMotorway:
      return add_motorway(mesh, road, place, random);
    case PlaceKind::kNoiseBarrier:
      return add_noise_barrier(mesh, road, place, random);
    case PlaceKind::kField:
      return add_field(mesh, road, place, random);
    case PlaceKind::kForest:
      return add_forest(mesh, road, place, random);
    case PlaceKind::kBridge:
      return add_bridge(mesh, road, place, random);
    case PlaceKind::kCarPark:
      return add_car_park(mesh, road, place);
    case PlaceKind::kPlaza:
      return add_plaza(mesh, road, place, random);
    case PlaceKind::kHills:
      return add_hills(mesh, road, place, random);
  }
}

}  // namespace

TownMesh hard_mesh(const Road& road) {
  TownMesh mesh;
  const std::vector<Place> built = built_places(road.places);
  for (std::size_t i = 0; i < built.size(); ++i) {
    add_place_ground(mesh, road, built[i]);
    add_place(mesh, road, built[i], Random(mix(mix(road.seed, kPlaceKey), i)));
  }
  return mesh;
}

void add_hard_cars(TownMesh& mesh, const Road& road, std::uint64_t drive) {
  const std::vector<Place> built = built_places(road.places);
  for (std::size_t i = 0; i < built.size(); ++i) {
    const std::uint64_t seed = mix(mix(road.seed, kCarsKey), i);
    if (built[i].kind == PlaceKind::kCarPark) {
      add_car_park_cars(mesh, road, built[i], {seed, drive});
    } else if (built[i].kind == PlaceKind::kTown) {
      add_street_cars(mesh, road, built[i], Random(mix(seed, drive)));
    }
  }
}

}  // namespace sightline::town
