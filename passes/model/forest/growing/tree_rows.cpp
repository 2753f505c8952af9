#include "passes/model/forest/growing/tree_rows.h"

#include <algorithm>
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

}  // namespace sightline
