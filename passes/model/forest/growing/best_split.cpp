// Most of the time that a forest takes to grow is spent here. What decides are scores in double,
// rounded as the formula says; how they are found must not show in the tree.
#include "passes/model/forest/growing/best_split.h"

#include <algorithm>

namespace sightline {
namespace {

using SumAndCount = TreeRows::SumAndCount;
using Doubles = double __attribute__((vector_size(16)));
using Masks = long long __attribute__((vector_size(16)));  // of two comparisons of doubles

Doubles both(double value) { return Doubles{value, value}; }
// Of two sums with counts.
Doubles sums(SumAndCount a, SumAndCount b) { return __builtin_shufflevector(a, b, 0, 2); }
Doubles counts(SumAndCount a, SumAndCount b) { return __builtin_shufflevector(a, b, 1, 3); }

// The order of one feature. Few splits are near the best one so far, so four at a time are asked by
// products alone. With Z the number of samples, T the sum of their labels, n and s those of the
// left side, a score is T^2 / Z + Z (s - n T / Z)^2 / (n (Z - n)).
class OrderSearch {
 public:
  OrderSearch(const TreeRows& rows, const Part& part, Split& best)
      : rows_(rows),
        part_(part),
        best_(best),
        size_(static_cast<double>(part.size)),
        mean_(part.label_sum / size_) {
    raise();
  }

  void search(std::uint32_t feature) {
    order_ = rows_.order(feature);
    rank_of_ = rows_.ranks(feature);
    feature_ = feature;
    if (rank_of_[order_[part_.begin]] == rank_of_[order_[part_.end - 1]]) return;
    SumAndCount left{0.0, 0.0};
    std::size_t i = part_.begin;
    for (; i + 4 < part_.end; i += 4) {
      const SumAndCount first = copies(i);
      const SumAndCount two = first + copies(i + 1);
      const SumAndCount third = copies(i + 2);
      const SumAndCount next[] = {left + first, left + two, left + (two + third),
                                  left + (two + (third + copies(i + 3)))};
      const Masks may_be_better = is_near(sums(next[0], next[1]), counts(next[0], next[1])) |
                                  is_near(sums(next[2], next[3]), counts(next[2], next[3]));
      if ((may_be_better[0] | may_be_better[1]) != 0) {
        for (std::size_t k = 0; k < 4; ++k) judge(i + k, next[k]);
      }
      left = next[3];
    }
    for (; i + 1 < part_.end; ++i) {
      left += copies(i);
      judge(i, left);
    }
  }

 private:
  [[nodiscard]] SumAndCount copies(std::size_t place) const {
    return rows_.copies(order_[place]).both;
  }

  // Rounding is worth less than the slack while a tree has fewer than 2^30 samples.
  void raise() {
    constexpr double kSlack = 1.0 - 1e-9;
    least_ = (best_.score * kSlack - part_.label_sum * mean_) / size_;
  }

  [[nodiscard]] Masks is_near(Doubles sum, Doubles count) const {
    const Doubles off = sum - both(mean_) * count;
    return off * off > both(least_) * (count * (both(size_) - count));
  }

  // Between this place and the next.
  void judge(std::size_t place, SumAndCount left) {
    if (rank_of_[order_[place]] == rank_of_[order_[place + 1]]) return;
    const double right_sum = part_.label_sum - left[0];
    const double score = left[0] * left[0] / left[1] + right_sum * right_sum / (size_ - left[1]);
    if (score <= best_.score) return;
    best_ = {score, left[0], static_cast<std::size_t>(left[1]), place + 1, feature_};
    raise();
  }

  const TreeRows& rows_;
  const Part& part_;
  Split& best_;
  double size_;
  double mean_;
  double least_ = 0.0;
  const std::uint32_t* order_ = nullptr;
  TreeRows::Ranks rank_of_{};
  std::uint32_t feature_ = 0;
};

// Of the places of two lanes: the higher score, on a tie the place that came first.
struct BestPlaces {
  Doubles score = {-1.0, -1.0};
  Masks place = {0, 0};  // number of the feature in the upper half

  void take(Doubles scores, Masks may_be, Masks places) {
    const Masks is_better = (scores > score) & may_be;
    score = reinterpret_cast<Doubles>((reinterpret_cast<Masks>(scores) & is_better) |
                                      (reinterpret_cast<Masks>(score) & ~is_better));
    place = (places & is_better) | (place & ~is_better);
  }
  [[nodiscard]] std::size_t lane() const {
    if (score[0] != score[1]) return score[0] > score[1] ? 0 : 1;
    return place[0] < place[1] ? 0 : 1;
  }
};

// Where rows are few, guessing branches wrong takes longer than all scores.
Split best_of_few(const TreeRows& rows, const Part& part, std::span<const std::uint32_t> features) {
  const auto size = static_cast<double>(part.size);
  const std::size_t last = part.end - 1;
  BestPlaces best;
  for (std::size_t k = 0; k < features.size(); ++k) {
    const std::uint32_t* order = rows.order(features[k]);
    const TreeRows::Ranks rank_of = rows.ranks(features[k]);
    std::uint32_t rank = rank_of[order[part.begin]];
    if (rank == rank_of[order[last]]) continue;
    SumAndCount left{0.0, 0.0};
    for (std::size_t i = part.begin; i < last; i += 2) {
      const SumAndCount first = left + rows.copies(order[i]).both;
      left = first + rows.copies(order[i + 1]).both;
      const std::uint32_t next = rank_of[order[i + 1]];
      const std::uint32_t after = rank_of[order[std::min(i + 2, last)]];  // none behind the last
      const Masks are_apart{rank != next ? -1 : 0, next != after ? -1 : 0};
      rank = after;
      const Doubles sum = sums(first, left);
      const Doubles count = counts(first, left);
      const Doubles right_sum = both(part.label_sum) - sum;
      const auto place = static_cast<long long>(k << 32U | i);
      best.take(sum * sum / count + right_sum * right_sum / (both(size) - count), are_apart,
                Masks{place, place + 1});
    }
  }
  const std::size_t lane = best.lane();
  if (best.score[lane] < 0.0) return {};
  const auto place = static_cast<std::uint64_t>(best.place[lane]);
  Split split{best.score[lane], 0.0, 0, (place & 0xffff'ffffU) + 1, features[place >> 32U]};
  SumAndCount left{0.0, 0.0};
  for (std::size_t i = part.begin; i < split.at; ++i) {
    left += rows.copies(rows.order(split.feature)[i]).both;
  }
  split.left_sum = left[0];
  split.left_size = static_cast<std::size_t>(left[1]);
  return split;
}

}  // namespace

Split best_split(const TreeRows& rows, const Part& part, std::span<const std::uint32_t> features) {
  constexpr std::size_t kFew = 16;
  if (part.end - part.begin <= kFew) return best_of_few(rows, part, features);
  Split best;
  OrderSearch search(rows, part, best);
  for (const std::uint32_t feature : features) search.search(feature);
  return best;
}

}  // namespace sightline
