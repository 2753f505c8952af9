#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

// The floats of a file read with each count of floats a point from 1 to 10; not for other folders.

namespace sightline {

constexpr std::size_t kLeastFloats = 3;
constexpr std::size_t kMostFloats = 10;

// How often a column holds each kind of number.
using KindHistogram = std::vector<double>;

// Of a large file only blocks spread over it are looked at.
class FloatReadings {
 public:
  explicit FloatReadings(std::span<const std::byte> bytes);

  // Whether a count that is no multiple explains the kinds of numbers better.
  [[nodiscard]] bool is_beaten(std::size_t count) const;
  // Whether the columns do not differ, or only every other one: then these are no points.
  [[nodiscard]] bool is_no_point(std::size_t count) const;
  // How unlike the points of `count` are that `multiple` makes one, 0 to 1, by what would be x and
  // y.
  [[nodiscard]] double divergence(std::size_t count, std::size_t multiple) const;
  // Whether most of them lie within 5 degrees of the one before them.
  [[nodiscard]] bool follow_each_other(std::size_t count, std::size_t multiple) const;
  // Whether x, y and z can be coordinates: a ring, a label or a time that stands first cannot, nor
  // can a row of which two are exactly 0 and one is not.
  [[nodiscard]] bool begins_with_coordinates(std::size_t count) const;

 private:
  struct Reading {
    std::vector<KindHistogram> columns;
    double entropy_bits = 0.0;  // of a float, given its column
  };

  [[nodiscard]] std::size_t size() const { return bytes_.size() / sizeof(float); }
  template <class Body>
  void for_each_float(Body body) const;
  void add_reading(std::size_t count);
  [[nodiscard]] std::optional<double> divergence_of(std::size_t column, std::size_t count,
                                                    std::size_t multiple) const;
  [[nodiscard]] bool has_fractions(std::size_t count, std::size_t column) const;
  [[nodiscard]] bool is_rising(std::size_t count) const;
  [[nodiscard]] bool has_lone_numbers(std::size_t count) const;

  std::span<const std::byte> bytes_;
  std::vector<std::pair<std::size_t, std::size_t>> kinds_;  // index and kind of each float
  std::vector<Reading> readings_;                           // of 1, 2, ... floats a point
};

}  // namespace sightline
