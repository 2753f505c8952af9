#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "examples/town/world/plan.h"
#include "formats/base/random.h"

// What routes of every shape are put together from; part of plan.

namespace sightline::town {

enum class Joint { kTurn, kCrossing, kBend, kPlain };

// Deals every value once in random order, then again in another.
template <class T>
class Deck {
 public:
  explicit Deck(std::vector<T> cards) : cards_(std::move(cards)) {}
  T deal(Random& random) {
    if (next_ == 0) {
      for (std::size_t i = cards_.size() - 1; i > 0; --i) {
        std::swap(cards_[i], cards_[random.below(i + 1)]);
      }
    }
    const T card = cards_[next_];
    next_ = (next_ + 1) % cards_.size();
    return card;
  }

 private:
  std::vector<T> cards_;
  std::size_t next_ = 0;
};

// A street of that kind with drawn widths and length, at the origin and heading along +x.
Street draw_street(StreetKind kind, Random& random);

// Where the town goes on beyond the route.
void add_side_street(TownPlan& plan, const Eigen::Vector2d& start_m, double heading_rad,
                     Random& random);

// Streets that leave a joint, so that the far field behind a corner is a street too.
void add_side_streets(TownPlan& plan, Joint joint, const Street& before, const Street& after,
                      Random& random);

// Both streets at a corner reach to the other's outer side.
void widen_corner(Street& before, Street& after);

// How much of each straight the rounding of a corner between them takes away, and how long the
// rounding is.
double tangent_length_m(double angle_rad, double radius_m);
double corner_radius_m(double angle_rad);

// Rounds the corners, and gives each of the first `on_route` streets its share of the line, which
// runs on straight for `beyond_m`.
DrivenLine trace_line(std::vector<Street>& streets, std::size_t on_route, double beyond_m);

}  // namespace sightline::town
