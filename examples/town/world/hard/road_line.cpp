// The course of a road: straights, bends whose curvature grows and falls evenly, and the loops of
// car parks. A bend turns back to where the road headed at first, so that the road never meets
// itself.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "examples/town/world/hard/road.h"

namespace sightline::town {
namespace {

constexpr std::uint64_t kBendKey = 0x62656e64ULL;
constexpr double kSteepest = 0.04;     // of hills
constexpr double kHill_m = 110.0;      // up and down
constexpr double kHillBlend_m = 12.0;  // in which the slope changes
constexpr double kRampBlend_m = 4.0;

// A piece of road whose curvature, 1/m and positive to the left, changes evenly.
struct Bend {
  double length_m = 0.0;
  double curvature_from = 0.0;
  double curvature_to = 0.0;
};

// Of the bends of such a place, m; none: straight. Tunnels, motorways and barriers are straight as
// often as not.
double bend_radius_m(PlaceKind kind, Random& random) {
  const double drawn = random.uniform();
  const bool is_straight = random.uniform() < 0.5;
  switch (kind) {
    case PlaceKind::kTunnel:
    case PlaceKind::kMotorway:
    case PlaceKind::kNoiseBarrier:
      return is_straight ? 0.0 : std::lerp(600.0, 1500.0, drawn);
    case PlaceKind::kForest:
      return std::lerp(150.0, 300.0, drawn);
    case PlaceKind::kHills:
      return std::lerp(250.0, 500.0, drawn);
    default:
      return 0.0;
  }
}

// A road that bends about every 120 m, to the left or right by chance where it heads along +x.
std::vector<Bend> open_bends(const Place& place, double heading_rad, Random& random) {
  constexpr double kBend_m = 120.0;
  constexpr double kBlend_m = 20.0;
  const int count = std::max(1, static_cast<int>(std::lround(place.length_m() / kBend_m)));
  const double held_m = place.length_m() / count - 2.0 * kBlend_m;
  std::vector<Bend> bends;
  for (int i = 0; i < count; ++i) {
    const double radius_m = bend_radius_m(place.kind, random);
    const bool is_left = heading_rad < -0.1 || (heading_rad < 0.1 && random.uniform() < 0.5);
    if (radius_m == 0.0 || held_m < kBlend_m) {
      bends.push_back({held_m + 2.0 * kBlend_m, 0.0, 0.0});
      continue;
    }
    const double curvature = (is_left ? 1.0 : -1.0) / radius_m;
    bends.insert(
        bends.end(),
        {{kBlend_m, 0.0, curvature}, {held_m, curvature, curvature}, {kBlend_m, curvature, 0.0}});
    heading_rad += curvature * (held_m + kBlend_m);
  }
  return bends;
}

std::vector<Bend> car_park_bends(const CarPark& car_park) {
  const double curvature = 1.0 / CarPark::kRadius_m;
  const Bend half_circle{std::numbers::pi * CarPark::kRadius_m, curvature, curvature};
  const Bend straight{car_park.straight_m, 0.0, 0.0};
  std::vector<Bend> bends = {{CarPark::kApproach_m, 0.0, 0.0}};
  for (int loop = 0; loop < car_park.loops; ++loop) {
    bends.insert(bends.end(), {straight, half_circle, straight, half_circle});
  }
  bends.insert(bends.end(), {straight, {CarPark::kApproach_m, 0.0, 0.0}});
  return bends;
}

// Follows bends in steps of kLineStepM, whatever their lengths.
class Tracer {
 public:
  void follow(const Bend& bend) {
    constexpr double kFine_m = 0.01;
    const int pieces = std::max(1, static_cast<int>(std::ceil(bend.length_m / kFine_m)));
    const double piece_m = bend.length_m / pieces;
    for (int i = 0; i < pieces; ++i) {
      const double share = (i + 0.5) / pieces;
      const double curvature = std::lerp(bend.curvature_from, bend.curvature_to, share);
      // Points on the way lie on the piece's middle direction; the error is below 1e-7 m.
      const double middle_rad = heading_rad_ + 0.5 * curvature * piece_m;
      for (; next_m_ <= s_m_ + piece_m; next_m_ += kLineStepM) {
        const double part_m = next_m_ - s_m_;
        line.points.push_back(
            {position_m_ + part_m * direction(middle_rad), heading_rad_ + curvature * part_m});
      }
      position_m_ += piece_m * direction(middle_rad);
      heading_rad_ += curvature * piece_m;
      s_m_ += piece_m;
    }
  }
  [[nodiscard]] double heading_rad() const { return heading_rad_; }
  DrivenLine line;

 private:
  Eigen::Vector2d position_m_ = Eigen::Vector2d::Zero();
  double heading_rad_ = 0.0;
  double s_m_ = 0.0;
  double next_m_ = 0.0;
};

struct Height {
  double height_m = 0.0;
  double slope = 0.0;
};

// A climb whose slope grows over its first blend_m, is even, and falls over its last.
struct Climb {
  double length_m = 0.0;
  double rise_m = 0.0;
  double blend_m = 1.0;

  [[nodiscard]] Height at(double along_m) const {
    const double steepest = rise_m / (length_m - blend_m);
    if (along_m <= 0.0) return {0.0, 0.0};
    if (along_m >= length_m) return {rise_m, 0.0};
    const double left_m = length_m - along_m;
    if (along_m < blend_m) {
      return {0.5 * steepest * along_m * along_m / blend_m, steepest * along_m / blend_m};
    }
    if (left_m < blend_m) {
      return {rise_m - 0.5 * steepest * left_m * left_m / blend_m, steepest * left_m / blend_m};
    }
    return {steepest * (along_m - 0.5 * blend_m), steepest};
  }
};

Height hill_height(const Place& place, double along_m) {
  const int hills = std::max(1, static_cast<int>(std::lround(place.length_m() / kHill_m)));
  const double side_m = 0.5 * place.length_m() / hills;
  const double blend_m = std::min(kHillBlend_m, 0.3 * side_m);
  const Climb climb{side_m, kSteepest * (side_m - blend_m), blend_m};
  const double within_m = along_m - 2.0 * side_m * std::floor(along_m / (2.0 * side_m));
  if (within_m < side_m) return climb.at(within_m);
  const Height down = climb.at(2.0 * side_m - within_m);
  return {down.height_m, -down.slope};
}

Height car_park_height(const CarPark& car_park, double along_m) {
  Height height;
  for (int i = 0; i < car_park.loops; ++i) {
    const Climb ramp{car_park.straight_m, CarPark::kStorey_m, kRampBlend_m};
    const Height part = ramp.at(along_m - car_park.ramp_from_m(i));
    height.height_m += part.height_m;
    height.slope += part.slope;
  }
  return height;
}

// Above where the place begins.
Height height_in(const Place& place, double along_m) {
  if (place.kind == PlaceKind::kHills) return hill_height(place, along_m);
  if (place.kind == PlaceKind::kCarPark) return car_park_height(car_park_of(place), along_m);
  return {};
}

void add_heights(DrivenLine& line, const std::vector<Place>& places) {
  double base_m = 0.0;
  std::size_t i = 0;
  for (const Place& place : places) {
    for (; i < line.points.size(); ++i) {
      const double along_m = static_cast<double>(i) * kLineStepM - place.from_m;
      if (along_m > place.length_m() && &place != &places.back()) break;
      const Height height = height_in(place, std::min(along_m, place.length_m()));
      line.points[i].height_m = base_m + height.height_m;
      line.points[i].slope = height.slope;
    }
    if (place.kind == PlaceKind::kCarPark) {
      base_m += car_park_of(place).loops * CarPark::kStorey_m;
    }
  }
}

}  // namespace

double CarPark::ramp_from_m(int i) const {
  const double half_m = straight_m + std::numbers::pi * kRadius_m;
  return kApproach_m + half_m + 2.0 * half_m * i;
}

CarPark car_park_of(const Place& place) {
  constexpr double kShortest_m = 18.0;  // of a straight: a ramp of 20 %
  const double circle_m = 2.0 * std::numbers::pi * CarPark::kRadius_m;
  const double inside_m = place.length_m() - 2.0 * CarPark::kApproach_m;
  CarPark car_park;
  const double loops = (inside_m - kShortest_m) / (circle_m + 2.0 * kShortest_m);
  car_park.loops = std::max(0, static_cast<int>(std::floor(loops)));
  car_park.straight_m = (inside_m - circle_m * car_park.loops) / (2.0 * car_park.loops + 1.0);
  return car_park;
}

DrivenLine make_road_line(std::uint64_t seed, const std::vector<Place>& places) {
  Tracer tracer;
  for (std::size_t i = 0; i < places.size(); ++i) {
    Random random(mix(mix(seed, kBendKey), i));
    const std::vector<Bend> bends =
        places[i].kind == PlaceKind::kCarPark
            ? car_park_bends(car_park_of(places[i]))
            : open_bends(places[i], std::remainder(tracer.heading_rad(), 2.0 * std::numbers::pi),
                         random);
    for (const Bend& bend : bends) tracer.follow(bend);
  }
  // The last step may end behind the last place.
  tracer.follow({kLineStepM, 0.0, 0.0});
  add_heights(tracer.line, places);
  return std::move(tracer.line);
}

}  // namespace sightline::town
