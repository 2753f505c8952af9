#include "passes/model/forest/growing/tree_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace sightline {
namespace {

// Without branches, which would be guessed wrong half the time: a row is written wherever it might
// belong, and written over where it does not.

void keep_left(std::uint32_t* begin, const std::uint32_t* end, const std::uint8_t* is_right) {
  std::uint32_t* left = begin;
  for (const std::uint32_t* next = begin; next != end; ++next) {
    const std::uint32_t row = *next;
    *left = row;
    left += 1 - is_right[row];
  }
}

void keep_right(const std::uint32_t* begin, std::uint32_t* end, const std::uint8_t* is_right) {
  std::uint32_t* right = end;
  for (const std::uint32_t* next = end; next != begin;) {
    const std::uint32_t row = *--next;
    right[-1] = row;
    right -= is_right[row];
  }
}

void keep_both(std::uint32_t* begin, const std::uint32_t* end, const std::uint8_t* is_right,
               std::uint32_t* scratch) {
  std::uint32_t* left = begin;
  std::uint32_t* right = scratch;
  for (const std::uint32_t* next = begin; next != end; ++next) {
    const std::uint32_t row = *next;
    const std::size_t goes_right = is_right[row];
    *left = row;
    *right = row;
    left += 1 - goes_right;
    right += goes_right;
  }
  std::copy(scratch, right, left);
}

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

TreeRows::TreeRows(const RankedColumns& ranks, const std::vector<double>& labels,
                   std::span<const std::uint32_t> draws)
    : ranks_(ranks),
      labels_(labels),
      feature_count_(static_cast<std::uint32_t>(ranks.feature_count())) {
  number_rows(draws);
  put_in_order();
  scratch_.resize(size());
  is_right_.resize(size());
}

void TreeRows::number_rows(std::span<const std::uint32_t> draws) {
  row_of_sample_.assign(labels_.size(), kNone);
  for (const std::uint32_t sample : draws) row_of_sample_[sample] = 0;
  for (std::uint32_t sample = 0; sample < row_of_sample_.size(); ++sample) {
    if (row_of_sample_[sample] == kNone) continue;
    row_of_sample_[sample] = static_cast<std::uint32_t>(sample_of_.size());
    sample_of_.push_back(sample);
  }
  copies_.resize(sample_of_.size());
  first_draw_.assign(sample_of_.size(), kNone);
  next_draw_.resize(draws.size());
  for (std::size_t draw = draws.size(); draw-- > 0;) {
    const std::uint32_t row = row_of_sample_[draws[draw]];
    next_draw_[draw] = std::exchange(first_draw_[row], static_cast<std::uint32_t>(draw));
    copies_[row].both += TreeRows::SumAndCount{labels_[draws[draw]], 1.0};
  }
}

void TreeRows::put_in_order() {
  // One more place: a sample that was not drawn is written there, and written over.
  orders_.resize(feature_count_ * size() + 1);
  std::uint32_t* place = orders_.data();
  for (std::uint32_t feature = 0; feature < feature_count_; ++feature) {
    for (const std::uint32_t sample : ranks_.order(feature)) {
      const std::uint32_t row = row_of_sample_[sample];
      *place = row;
      place += row == kNone ? 0 : 1;
    }
  }
}

double TreeRows::take_copy(std::uint32_t row) {
  const double label = labels_[sample_of_[row]];
  first_draw_[row] = next_draw_[first_draw_[row]];
  copies_[row].both -= TreeRows::SumAndCount{label, 1.0};
  return label;
}

void TreeRows::part(const Sides& sides, std::uint32_t sure) {
  for (std::uint32_t feature = 0; feature < feature_count_; ++feature) {
    std::uint32_t* rows = &orders_[feature * size()];
    const Ranks rank_of = ranks(feature);
    if (feature != sure && rank_of[rows[sides.begin]] == rank_of[rows[sides.end - 1]]) continue;
    if (!sides.keeps_right) {
      keep_left(rows + sides.begin, rows + sides.end, is_right_.data());
    } else if (!sides.keeps_left) {
      keep_right(rows + sides.begin, rows + sides.end, is_right_.data());
    } else {
      keep_both(rows + sides.begin, rows + sides.end, is_right_.data(), scratch_.data());
    }
  }
}

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
