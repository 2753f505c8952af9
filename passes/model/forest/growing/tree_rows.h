#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "passes/model/forest/growing/ranked_columns.h"

namespace sightline {

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
