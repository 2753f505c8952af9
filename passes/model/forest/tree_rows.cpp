#include "passes/model/forest/tree_rows.h"

#include <algorithm>
#include <utility>

namespace sightline {

TreeRows::TreeRows(const RankedColumns& ranks, const std::vector<double>& labels,
                   std::span<const std::uint32_t> draws)
    : labels_(labels), feature_count_(static_cast<std::uint32_t>(ranks.feature_count())) {
  number_rows(draws);
  put_in_order(ranks);
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
    copies_[row].label_sum += labels_[draws[draw]];
    ++copies_[row].count;
  }
}

void TreeRows::put_in_order(const RankedColumns& ranks) {
  // One more place: a sample that was not drawn is written there, and written over.
  orders_.resize(feature_count_ * size() + 1);
  row_ranks_.reserve(feature_count_ * size());
  std::uint32_t* place = orders_.data();
  for (std::uint32_t feature = 0; feature < feature_count_; ++feature) {
    for (const std::uint32_t sample : ranks.order(feature)) {
      const std::uint32_t row = row_of_sample_[sample];
      *place = row;
      place += row == kNone ? 0 : 1;
    }
    const std::uint32_t* column = ranks.column(feature);
    for (const std::uint32_t sample : sample_of_) row_ranks_.push_back(column[sample]);
  }
}

double TreeRows::take_copy(std::uint32_t row) {
  const double label = labels_[sample_of_[row]];
  first_draw_[row] = next_draw_[first_draw_[row]];
  copies_[row].label_sum -= label;
  --copies_[row].count;
  return label;
}

void TreeRows::part(std::size_t begin, std::size_t end, std::uint32_t sure) {
  for (std::uint32_t feature = 0; feature < feature_count_; ++feature) {
    std::uint32_t* rows = &orders_[feature * size()];
    const std::uint32_t* rank_of = ranks(feature);
    if (feature != sure && rank_of[rows[begin]] == rank_of[rows[end - 1]]) continue;
    std::uint32_t* left = rows + begin;
    std::uint32_t* right = scratch_.data();
    // Without a branch, which would be guessed wrong half the time.
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t row = rows[i];
      const std::size_t goes_right = is_right_[row];
      *left = row;
      *right = row;
      left += 1 - goes_right;
      right += goes_right;
    }
    std::copy(scratch_.data(), right, left);
  }
}

}  // namespace sightline
