#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/surroundings/surface.h"

namespace sightline {

inline constexpr int kSquaresOfPatch = kPatchSquares * kPatchSquares;
// A return farther from a plane, as a share of the patch's half side, is no part of it.
inline constexpr double kMostOffPlane = 0.3;

// A patch with its axes at hand.
struct PatchPlane {
  Eigen::Vector3d centre_m, normal, side, other_side;
  double half_side_m = 0.0;

  explicit PatchPlane(const SurfacePatch& patch);
  // The square across which a place lies; -1 beside the patch.
  [[nodiscard]] int square_of(const Eigen::Vector3d& place_m) const;
  // The same for a return; -1 also for one that is no part of the patch.
  [[nodiscard]] int square_of_return(const Eigen::Vector3d& place_m) const;
  [[nodiscard]] Eigen::Vector3d middle_m(int square) const;
};

// Sine of the angle between a ray and a plane (10 degrees). Seen more edge-on, the place where a
// ray crosses is off by more than a square wherever the plane is off by two centimetres.
inline constexpr double kLeastSlope = 0.17;

// Where returns lie on patches and rays cross them, in float and four numbers at once, with more
// room than float loses: where that does not tell, PatchPlane does.
class PatchLanes {
 public:
  PatchLanes() = default;
  // For places within the box.
  PatchLanes(std::span<const PatchPlane> planes, const Eigen::AlignedBox3d& box_m);

  // A place as float.
  struct Place {
    float x_m = 0.0F;  // from the middle of the box
    float y_m = 0.0F;
    float z_m = 0.0F;
  };
  [[nodiscard]] Place place_of(const Eigen::Vector3d& place_m) const {
    const Eigen::Vector3f from_middle_m = (place_m - middle_m_).cast<float>();
    return {from_middle_m.x(), from_middle_m.y(), from_middle_m.z()};
  }
  // Places, so many at once.
  static constexpr std::size_t kAtOnce = 4;
  class Places;

  // A ray as float, and how much that may lose of it.
  struct Ray {
    Place from, direction;
    float slacks = 0.0F;   // of a place on a patch, as multiples of that of places in the box
    float slack_m = 0.0F;  // along the ray
  };
  // `direction` of length 1; the ray is asked about so far.
  [[nodiscard]] Ray ray_of(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction,
                           double length_m) const;

  static constexpr int kUnsure = -2;
  // One patch, at hand for many places.
  class Patch;
  [[nodiscard]] Patch patch(std::uint32_t patch) const;

 private:
  // On x86-64 four floats are one register.
  using Floats = float __attribute__((vector_size(16)));
  using Ints = std::int32_t __attribute__((vector_size(16)));
  using Bits = std::uint32_t __attribute__((vector_size(16)));

  // What a place has three of: how far it is from the plane, its column and its row, each given so
  // that what decides are whole numbers. The plane from 0 to 1 in its room for returns, squares
  // from 0 to kPatchSquares. Last how much float may lose of them.
  struct Lanes {
    Floats per_x_m, per_y_m, per_z_m, at_middle;
  };

  Eigen::Vector3d middle_m_ = Eigen::Vector3d::Zero();
  double edges_m_ = 0.0;  // sum
  double slack_m_ = 0.0;  // of where a ray crosses the widest patch
  std::vector<Lanes> lanes_;
};

class PatchLanes::Places {
 public:
  void clear() {
    some_.clear();
    size_ = 0;
  }
  void add(const Place& place) {
    const std::size_t lane = size_++ % kAtOnce;
    if (lane == 0) some_.emplace_back();
    some_.back().x_m[lane] = place.x_m;
    some_.back().y_m[lane] = place.y_m;
    some_.back().z_m[lane] = place.z_m;
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  friend class Patch;
  struct Some {
    Floats x_m{}, y_m{}, z_m{};
  };
  std::vector<Some> some_;
  std::size_t size_ = 0;
};

class PatchLanes::Patch {
 public:
  // Of the places from `first` on, a multiple of kAtOnce: as PatchPlane::square_of_return(), or
  // kUnsure. What stands for places behind the last one means nothing.
  [[nodiscard]] std::array<std::int32_t, kAtOnce> squares_of(const Places& places,
                                                             std::size_t first) const {
    const Places::Some& some = places.some_[first / kAtOnce];
    const Floats off = lane_of<0>(some);
    const Floats column = lane_of<1>(some);
    const Floats row = lane_of<2>(some);
    const Ints beside =
        is_beyond(off, 1.0F) | is_beyond(column, kPatchSquares) | is_beyond(row, kPatchSquares);
    const Ints unsure = is_near_whole(off) | is_near_whole(column) | is_near_whole(row);
    // Unsigned: the result of places far beside is not used.
    const auto in_rows = std::bit_cast<Bits>(__builtin_convertvector(row, Ints));
    const auto in_columns = std::bit_cast<Bits>(__builtin_convertvector(column, Ints));
    const auto square = std::bit_cast<Ints>(kPatchSquares * in_rows + in_columns);
    // Each of all bits or none: -1 where beside, else -2 where unsure, else the square.
    const Ints found = beside | (~beside & ((unsure & kUnsure) | (~unsure & square)));
    return std::bit_cast<std::array<std::int32_t, kAtOnce>>(found);
  }

  // False only where a ray does not cross the patch between two distances along it, which are given
  // with the ray's slack, or at an angle whose sine is below kLeastSlope.
  [[nodiscard]] bool may_cross(const Ray& ray, float enter_m, float leave_m) const {
    constexpr float kMiddle = 0.5F * kPatchSquares;
    const Floats from =
        per_x_m_ * ray.from.x_m + per_y_m_ * ray.from.y_m + (per_z_m_ * ray.from.z_m + at_middle_);
    const Floats per_m =
        per_x_m_ * ray.direction.x_m + per_y_m_ * ray.direction.y_m + per_z_m_ * ray.direction.z_m;
    const float along_m = (0.5F - from[0]) / per_m[0];
    const Floats at = from + per_m * along_m;
    const float reach = kMiddle + ray.slacks * at_middle_[3];
    // All at once: which of them fails cannot be predicted. What is no number does not fail.
    const float from_middle = std::max(std::abs(at[1] - kMiddle), std::abs(at[2] - kMiddle));
    const bool is_outside = (along_m < enter_m) | (along_m > leave_m);
    return !(is_outside | (from_middle > reach));
  }

 private:
  friend class PatchLanes;
  explicit Patch(const Lanes& lanes)
      : per_x_m_(lanes.per_x_m),
        per_y_m_(lanes.per_y_m),
        per_z_m_(lanes.per_z_m),
        at_middle_(lanes.at_middle),
        slack_(lanes.at_middle[3]) {}

  template <int lane>
  [[nodiscard]] Floats lane_of(const Places::Some& some) const {
    return per_x_m_[lane] * some.x_m + per_y_m_[lane] * some.y_m +
           (per_z_m_[lane] * some.z_m + at_middle_[lane]);
  }
  // By more than float loses.
  [[nodiscard]] Ints is_beyond(const Floats& at, float end) const {
    return (at < -slack_) | (at > end + slack_);
  }
  // Where float may lose what decides; a little more, since the ends of is_beyond() are rounded.
  [[nodiscard]] Ints is_near_whole(const Floats& at) const {
    constexpr float kWhole = 0x1.8p23F;  // added, it rounds to a whole number
    const Floats off = at - ((at + kWhole) - kWhole);
    const float unsure = slack_ + 0x1.0p-20F;
    return (off < unsure) & (off > -unsure);
  }

  Floats per_x_m_, per_y_m_, per_z_m_, at_middle_;
  float slack_;
};

inline PatchLanes::Patch PatchLanes::patch(std::uint32_t patch) const {
  return Patch(lanes_[patch]);
}

}  // namespace sightline
