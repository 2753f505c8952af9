#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

// Things in the order of their cells, so that who asks for a cell has them together. Keeps its
// memory from one sort() to the next.
class SortedByCell {
 public:
  // numbers[i]: of the cell of thing i, below cell_count or kNone.
  static constexpr std::uint32_t kNone = 0xffffffff;
  void sort(std::span<const std::uint32_t> numbers, std::size_t cell_count) {
    begin_.assign(cell_count + 2, 0);
    // A cell's begin stands one further on until its things have moved it there.
    for (const std::uint32_t number : numbers) {
      if (number != kNone) ++begin_[number + 2];
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    order_.resize(begin_.back());
    for (std::uint32_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] != kNone) order_[begin_[numbers[i] + 1]++] = i;
    }
  }

  // Ascending.
  [[nodiscard]] std::span<const std::uint32_t> things_of(std::uint32_t cell) const {
    return std::span(order_).subspan(begin_[cell], begin_[cell + 1] - begin_[cell]);
  }
  // The thing some places further on in the order, if there is one: to be asked for ahead. `thing`
  // is one of things_of().
  [[nodiscard]] std::uint32_t later(const std::uint32_t& thing) const {
    constexpr std::ptrdiff_t kAhead = 12;
    const std::uint32_t* const last = &order_.back();
    return last - &thing > kAhead ? *(&thing + kAhead) : *last;
  }

 private:
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> begin_;  // by cell, in order_; and the end
};

}  // namespace sightline
