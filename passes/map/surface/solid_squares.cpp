#include "passes/map/surface/solid_squares.h"

#include <vector>

namespace sightline {
namespace {

struct Place {
  int column = 0;
  int row = 0;
};

// Positive where c lies to the left of the way from a to b.
int turn(const Place& a, const Place& b, const Place& c) {
  return (b.column - a.column) * (c.row - a.row) - (b.row - a.row) * (c.column - a.column);
}

// Andrew's monotone chain: one half of the hull of places in order, from the first to the last.
std::vector<Place> half_hull(const std::vector<Place>& places) {
  std::vector<Place> hull;
  for (const Place& place : places) {
    while (hull.size() >= 2 && turn(hull[hull.size() - 2], hull.back(), place) <= 0) {
      hull.pop_back();
    }
    hull.push_back(place);
  }
  return hull;
}

bool is_left_of_all(const std::vector<Place>& way, const Place& place) {
  for (std::size_t i = 1; i < way.size(); ++i) {
    if (turn(way[i - 1], way[i], place) < 0) return false;
  }
  return true;
}

bool has(std::uint64_t squares, int square) { return (squares >> square & 1) != 0; }

template <class Holds>
std::uint64_t squares_where(const Holds& holds) {
  std::uint64_t squares = 0;
  for (int square = 0; square < kSquaresOfPatch; ++square) {
    if (holds(static_cast<std::size_t>(square))) squares |= std::uint64_t{1} << square;
  }
  return squares;
}

}  // namespace

std::uint64_t stopping_squares(const SquareCounts& counts, double returns_per_pass) {
  return squares_where([&](std::size_t i) {
    return counts.returns[i] > 0 && returns_per_pass * counts.passes[i] <= counts.returns[i];
  });
}

std::uint64_t open_squares(const SquareCounts& counts, double returns_per_pass) {
  return squares_where(
      [&](std::size_t i) { return returns_per_pass * counts.passes[i] > counts.returns[i]; });
}

std::uint64_t between_rows(std::uint64_t squares) {
  std::uint64_t from_below = squares;
  std::uint64_t from_above = squares;
  for (int row = 1; row < kPatchSquares; ++row) {
    from_below |= from_below << kPatchSquares;
    from_above |= from_above >> kPatchSquares;
  }
  return from_below & from_above;
}

std::uint64_t convex_hull(std::uint64_t squares) {
  std::vector<Place> places;  // column by column, from below
  Place low{kPatchSquares, kPatchSquares};
  Place high{-1, -1};
  for (int column = 0; column < kPatchSquares; ++column) {
    for (int row = 0; row < kPatchSquares; ++row) {
      if (!has(squares, kPatchSquares * row + column)) continue;
      places.push_back({column, row});
      low = {std::min(low.column, column), std::min(low.row, row)};
      high = {std::max(high.column, column), std::max(high.row, row)};
    }
  }
  const std::vector<Place> below = half_hull(places);
  const std::vector<Place> above = half_hull({places.rbegin(), places.rend()});
  return squares | squares_where([&](std::size_t i) {
           const Place place{static_cast<int>(i) % kPatchSquares,
                             static_cast<int>(i) / kPatchSquares};
           // A line of squares has no inside, and nothing lies left of both its directions but
           // itself.
           return place.column >= low.column && place.column <= high.column &&
                  place.row >= low.row && place.row <= high.row && is_left_of_all(below, place) &&
                  is_left_of_all(above, place);
         });
}

}  // namespace sightline
