#pragma once

#include <cstdint>
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

}  // namespace sightline
