#include "passes/model/forest/growing/ranked_columns.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace sightline {
namespace {

void insertion_sort(std::span<KeyedRow> rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const KeyedRow row = rows[i];
    std::size_t at = i;
    for (; at > 0 && key_of(rows[at - 1]) > key_of(row); --at) rows[at] = rows[at - 1];
    rows[at] = row;
  }
}

// One digit of a radix sort: its bits of the key, and where rows with each of its values go next.
struct Digit {
  unsigned shift = 0;
  std::uint32_t mask = 0;
  std::uint32_t* begins = nullptr;

  [[nodiscard]] std::uint32_t& begin_of(KeyedRow row) const {
    return begins[key_of(row) >> shift & mask];
  }
};

constexpr int kMostDigits = 5;
constexpr std::size_t kMostCounts = std::size_t{3} << 11U;  // more than 5 digits of 7 bits need
using Counts = std::array<std::uint32_t, kMostCounts>;

// The digits of `bits` bits, the lowest first, each of at most `digit_bits`. Returns how many.
std::size_t cut_in_digits(int bits, int digit_bits, std::array<Digit, kMostDigits>& digits,
                          Counts& counts) {
  const int count = (bits + digit_bits - 1) / digit_bits;
  std::uint32_t* begins = counts.data();
  for (int i = 0; i < count; ++i) {
    const int shift = bits * i / count;
    const int end = bits * (i + 1) / count;
    const std::uint32_t values = 1U << static_cast<unsigned>(end - shift);
    digits[static_cast<std::size_t>(i)] = {static_cast<unsigned>(shift), values - 1U, begins};
    std::fill_n(begins, values, 0U);
    begins += values;
  }
  return static_cast<std::size_t>(count);
}

// How often each value of each digit occurs, in one reading; from that where each one begins.
void count_values(std::span<const KeyedRow> rows, std::span<const Digit> digits) {
  for (const KeyedRow row : rows) {
    for (const Digit& digit : digits) ++digit.begin_of(row);
  }
  for (const Digit& digit : digits) {
    std::uint32_t sum = 0;
    for (std::uint32_t value = 0; value <= digit.mask; ++value) {
      sum += std::exchange(digit.begins[value], sum);
    }
  }
}

// Ordered as the floats are; both zeros are one.
std::uint32_t ordered_bits(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);
  return (bits & 0x8000'0000U) == 0 ? bits | 0x8000'0000U : ~bits;
}

}  // namespace

void sort_keyed_rows(std::span<KeyedRow> rows, std::span<KeyedRow> scratch, int bits) {
  constexpr std::size_t kFew = 24;
  constexpr std::size_t kMany = 512;
  if (rows.size() <= kFew) {
    insertion_sort(rows);
    return;
  }
  // Wide digits pay where there are many rows to count.
  const int digit_bits = rows.size() < kMany ? 7 : 11;
  Counts counts;
  std::array<Digit, kMostDigits> of_key;
  const std::span<const Digit> digits =
      std::span(of_key).first(cut_in_digits(bits, digit_bits, of_key, counts));
  count_values(rows, digits);
  std::span<KeyedRow> from = rows;
  std::span<KeyedRow> to = scratch;
  for (const Digit digit : digits) {
    for (const KeyedRow row : from) to[digit.begin_of(row)++] = row;
    std::swap(from, to);
  }
  if (from.data() != rows.data()) std::ranges::copy(from, rows.begin());
}

RankedColumns::RankedColumns(const std::vector<const float*>& rows, std::size_t feature_count)
    : row_count_(rows.size()), feature_count_(feature_count), ranks_(rows.size() * feature_count) {
  std::vector<KeyedRow> order(rows.size());
  std::vector<KeyedRow> scratch(rows.size());
  for (std::size_t feature = 0; feature < feature_count; ++feature) {
    for (std::uint32_t row = 0; row < rows.size(); ++row) {
      order[row] = keyed_row(ordered_bits(rows[row][feature]), row);
    }
    sort_keyed_rows(order, scratch, 32);
    std::uint32_t rank = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i > 0 && key_of(order[i]) != key_of(order[i - 1])) ++rank;
      ranks_[feature * row_count_ + row_of(order[i])] = rank;
      orders_.push_back(row_of(order[i]));
    }
  }
}

}  // namespace sightline
