#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sightline {

// A row behind a key that orders it: the key in the upper half, so that one sort moves both.
using KeyedRow = std::uint64_t;

inline KeyedRow keyed_row(std::uint32_t key, std::uint32_t row) {
  return KeyedRow{key} << 32U | row;
}
inline std::uint32_t key_of(KeyedRow keyed) { return static_cast<std::uint32_t>(keyed >> 32U); }
inline std::uint32_t row_of(KeyedRow keyed) { return static_cast<std::uint32_t>(keyed); }

// Sorts by the keys, which are below 2^bits, and keeps the order of rows with equal keys. `scratch`
// has the same size.
void sort_keyed_rows(std::span<KeyedRow> rows, std::span<KeyedRow> scratch, int bits);

// For each feature, the rank of each row's value among the values that occur: equal values have
// equal ranks.
class RankedColumns {
 public:
  // Values are finite; rows[i] has one for each feature.
  RankedColumns(const std::vector<const float*>& rows, std::size_t feature_count);

  [[nodiscard]] std::size_t feature_count() const { return feature_count_; }
  [[nodiscard]] const std::uint32_t* column(std::size_t feature) const {
    return &ranks_[feature * row_count_];
  }
  // Rows, ascending by rank, then by their numbers.
  [[nodiscard]] std::span<const std::uint32_t> order(std::size_t feature) const {
    return std::span(orders_).subspan(feature * row_count_, row_count_);
  }

 private:
  std::size_t row_count_;
  std::size_t feature_count_;
  std::vector<std::uint32_t> ranks_;   // [feature][row]
  std::vector<std::uint32_t> orders_;  // [feature]
};

// A bootstrap sample in the order of each feature: a row for each sample that was drawn, numbered
// from 0 on, whatever the number of its copies. A split parts the rows of a node in all orders,
// each in one reading.
class TreeRows {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // The sum of some labels and how many they are, both exact, so that they may be added in any
  // order: two numbers that the processor adds at once.
  using SumAndCount = double __attribute__((vector_size(16)));
  // All copies of a row.
  struct Copies {
    SumAndCount both = {0.0, 0.0};

    [[nodiscard]] double label_sum() const { return both[0]; }
    [[nodiscard]] double count() const { return both[1]; }
  };
  // The ranks of all rows among the values of a feature.
  struct Ranks {
    const std::uint32_t* of_sample;
    const std::uint32_t* sample_of;

    std::uint32_t operator[](std::uint32_t row) const { return of_sample[sample_of[row]]; }
  };
  // What becomes of the rows at places [begin, end): those of the left side stand before `at`.
  struct Sides {
    std::size_t begin = 0;
    std::size_t at = 0;
    std::size_t end = 0;
    bool keeps_left = true;  // a side that is not kept may hold anything afterwards
    bool keeps_right = true;
  };

  // draws[i] is the number of a sample. All that is given must outlive the rows.
  TreeRows(const RankedColumns& ranks, const std::vector<double>& labels,
           std::span<const std::uint32_t> draws);

  [[nodiscard]] std::size_t size() const { return copies_.size(); }
  [[nodiscard]] std::uint32_t sample_of(std::uint32_t row) const { return sample_of_[row]; }
  [[nodiscard]] const Copies& copies(std::uint32_t row) const { return copies_[row]; }
  [[nodiscard]] Ranks ranks(std::uint32_t feature) const {
    return {ranks_.column(feature), sample_of_.data()};
  }
  // Rows, ascending by rank within each part that was made, unless all of it have one rank: then
  // they may be any others of that rank.
  [[nodiscard]] const std::uint32_t* order(std::uint32_t feature) const {
    return &orders_[feature * size()];
  }
  // Of a row's copies that are left, the one that was drawn first.
  [[nodiscard]] std::uint32_t first_draw(std::uint32_t row) const { return first_draw_[row]; }

  // Takes that copy away; returns its label.
  double take_copy(std::uint32_t row);
  // Which side of the next split a row goes to.
  void set_side(std::uint32_t row, bool is_right) { is_right_[row] = is_right ? 1 : 0; }
  // All orders, left rows first, order kept; for certain in that of `sure`, where they must have
  // been the rows of the part.
  void part(const Sides& sides, std::uint32_t sure);

 private:
  void number_rows(std::span<const std::uint32_t> draws);
  void put_in_order();

  const RankedColumns& ranks_;
  const std::vector<double>& labels_;
  std::vector<std::uint32_t> sample_of_;
  std::vector<std::uint32_t> row_of_sample_;
  std::vector<Copies> copies_;
  std::vector<std::uint32_t> first_draw_;
  std::vector<std::uint32_t> next_draw_;  // [draw]: the next one of the same row
  std::vector<std::uint32_t> orders_;     // [feature]
  std::vector<std::uint32_t> scratch_;
  std::vector<std::uint8_t> is_right_;
  std::uint32_t feature_count_;
};

}  // namespace sightline
