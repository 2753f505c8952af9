#include "passes/model/forest/ranked_columns.h"

#include <algorithm>
#include <array>
#include <bit>

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

// One pass of a radix sort, by `bits` bits of the key from `shift` on.
void sort_by_digit(std::span<const KeyedRow> from, std::span<KeyedRow> to, int shift, int bits) {
  constexpr int kMostBits = 11;
  std::array<std::uint32_t, std::size_t{1} << kMostBits> ends;
  const std::uint32_t mask = (1U << static_cast<unsigned>(bits)) - 1U;
  const auto digit = [&](KeyedRow row) {
    return key_of(row) >> static_cast<unsigned>(shift) & mask;
  };
  std::fill_n(ends.begin(), mask + 1, 0U);
  for (const KeyedRow row : from) ++ends[digit(row)];
  std::uint32_t begin = 0;
  for (std::uint32_t i = 0; i <= mask; ++i) {
    const std::uint32_t count = ends[i];
    ends[i] = begin;
    begin += count;
  }
  for (const KeyedRow row : from) to[ends[digit(row)]++] = row;
}

// Ordered as the floats are; both zeros are one.
std::uint32_t ordered_bits(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);
  return (bits & 0x8000'0000U) == 0 ? bits | 0x8000'0000U : ~bits;
}

}  // namespace

void sort_keyed_rows(std::span<KeyedRow> rows, std::span<KeyedRow> scratch, int bits) {
  constexpr std::size_t kFew = 40;
  constexpr std::size_t kMany = 512;
  if (rows.size() <= kFew) {
    insertion_sort(rows);
    return;
  }
  // Wide digits pay where there are many rows to count.
  const int most_bits = rows.size() < kMany ? 6 : 11;
  const int passes = (bits + most_bits - 1) / most_bits;
  std::span<KeyedRow> from = rows;
  std::span<KeyedRow> to = scratch;
  for (int pass = 0; pass < passes; ++pass) {
    const int begin = bits * pass / passes;
    sort_by_digit(from, to, begin, bits * (pass + 1) / passes - begin);
    std::swap(from, to);
  }
  if (from.data() != rows.data()) std::ranges::copy(from, rows.begin());
}

RankedColumns::RankedColumns(const std::vector<const float*>& rows, std::size_t feature_count)
    : row_count_(rows.size()), ranks_(rows.size() * feature_count) {
  std::vector<KeyedRow> order(rows.size());
  std::vector<KeyedRow> scratch(rows.size());
  std::uint32_t most = 0;
  for (std::size_t feature = 0; feature < feature_count; ++feature) {
    for (std::uint32_t row = 0; row < rows.size(); ++row) {
      order[row] = keyed_row(ordered_bits(rows[row][feature]), row);
    }
    sort_keyed_rows(order, scratch, 32);
    std::uint32_t rank = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i > 0 && key_of(order[i]) != key_of(order[i - 1])) ++rank;
      ranks_[feature * row_count_ + row_of(order[i])] = rank;
    }
    most = std::max(most, rank);
  }
  bits_ = static_cast<int>(std::bit_width(most));
}

}  // namespace sightline
