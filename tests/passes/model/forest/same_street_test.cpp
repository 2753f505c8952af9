#include "passes/model/forest/same_street.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_places.h"

namespace sightline {
namespace {

const SyntheticOptions kStreet = {.site_count = 300, .ranges_m = {10.0, 20.0}};

// The same street, as the map of another drive shows it: each factor a little different.
DrivenPlace mapped_again(DrivenPlace place, std::uint64_t seed) {
  Random random(seed);
  for (double& value : place.factors.values) value *= 1.0 + 0.05 * random.normal();
  place.recordings = synthetic_recordings(1000 + seed);
  return place;
}

void move(const Eigen::Vector3d& by_m, DrivenPlace& place) {
  place.sites.frame.origin_world_m += by_m;
}

TEST(SameStreet, IsFoundInANewMapOfIt) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const DrivenPlace place = place_driven_twice(seed, kStreet);
    EXPECT_TRUE(is_one_street(place, mapped_again(place, seed))) << seed;
  }
}

TEST(SameStreet, IsNoneOfStreetsThatAllBeginAtTheOrigin) {
  for (std::uint64_t a = 1; a <= 15; ++a) {
    for (std::uint64_t b = 1; b < a; ++b) {
      EXPECT_FALSE(is_one_street(place_driven_twice(a, kStreet), place_driven_twice(b, kStreet)))
          << a << " and " << b;
    }
  }
}

// Sites from `first` on, in axes of their own.
DrivenPlace part_of(const DrivenPlace& place, std::size_t first, std::size_t count) {
  DrivenPlace part = place;
  const auto begin = place.sites.sites.begin() + static_cast<std::ptrdiff_t>(first);
  part.sites.sites.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
  const auto width = static_cast<std::ptrdiff_t>(place.factors.values_per_site());
  const auto values = place.factors.values.begin() + static_cast<std::ptrdiff_t>(first) * width;
  part.factors.values.assign(values, values + static_cast<std::ptrdiff_t>(count) * width);
  part.factors.site_count = static_cast<std::uint32_t>(count);
  move({-40.0, 900.0, 3.0}, part);
  return part;
}

DrivenPlace driven_back(const DrivenPlace& place) {
  DrivenPlace back = place;
  const std::size_t width = place.factors.values_per_site();
  for (std::size_t site = 0; site < place.factors.site_count; ++site) {
    const std::size_t from = (place.factors.site_count - 1 - site) * width;
    for (std::size_t i = 0; i < width; ++i) {
      back.factors.values[site * width + i] = place.factors.values[from + i];
    }
  }
  return back;
}

TEST(SameStreet, IsFoundInAnyAxesInEitherDirectionAndOfAPart) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const DrivenPlace place = place_driven_twice(seed, kStreet);
    const DrivenPlace again = mapped_again(place, seed);
    EXPECT_TRUE(is_one_street(place, part_of(again, 100, 120))) << seed;
    EXPECT_TRUE(is_one_street(part_of(again, 0, 180), part_of(place, 110, 190))) << seed;
    EXPECT_TRUE(is_one_street(driven_back(place), part_of(again, 100, 150))) << seed;
  }
}

TEST(SameStreet, NeedsAFifthOfTheShorterRoute) {
  const DrivenPlace place = place_driven_twice(1, kStreet);
  const DrivenPlace again = mapped_again(place, 2);
  EXPECT_FALSE(is_one_street(part_of(place, 0, 150), part_of(again, 130, 170))) << "20 m";
  EXPECT_FALSE(is_one_street(part_of(place, 0, 50), again)) << "too short to tell";
}

TEST(SameStreet, IsDecidedByPositionsInWorldCoordinates) {
  DrivenPlace place = place_driven_twice(1, kStreet);
  DrivenPlace other = place_driven_twice(2, kStreet);
  for (DrivenPlace* each : {&place, &other}) move({588000.0, 4141000.0, 0.0}, *each);
  EXPECT_TRUE(is_one_street(place, other));
  move({0.0, 25.0, 0.0}, other);
  EXPECT_FALSE(is_one_street(place, other));
}

TEST(SameStreet, JoinsPlacesThatShareNoRecording) {
  DrivenPlaces places = places_driven_twice(3, kStreet);
  places.places.push_back(mapped_again(places.places[1], 5));
  const Origins origins = origins_of(places);
  EXPECT_EQ(origins.places, (std::vector<std::uint32_t>{0, 1, 2, 1}));
  EXPECT_NE(origins.recordings[1], origins.recordings[3]);
}

}  // namespace
}  // namespace sightline
