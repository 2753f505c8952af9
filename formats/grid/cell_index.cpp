#include "formats/grid/cell_index.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "formats/base/check.h"

namespace sightline {
namespace {

// Without a branch.
bool is_same(const CellKey& a, const CellKey& b) {
  return ((a.x ^ b.x) | (a.y ^ b.y) | (a.z ^ b.z)) == 0;
}

// floor(x / cell) of `count` coordinates. The product with 1 / cell is as good, and far cheaper,
// wherever it does not lie at a whole number. Adding 1.5 * 2^52 rounds to a whole number and leaves
// it in the low bits. No branch and no conversion: the first loop becomes vector code on any
// x86-64.
void floor_quotients(const double* x_m, std::size_t count, double cell_m, std::int32_t* numbers) {
  constexpr double kWhole = 0x1.8p52;
  constexpr double kSure = 0.5 - 1e-6;  // product and quotient differ by far less than the rest
  const double per_m = 1.0 / cell_m;
  std::int64_t doubts = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double product = x_m[i] * per_m - 0.5;
    const double shifted = product + kWhole;
    numbers[i] = static_cast<std::int32_t>(std::bit_cast<std::int64_t>(shifted));
    // Positive doubles compare as their bits do: the sign says that this one is larger.
    const double rest = std::abs(product - (shifted - kWhole));
    doubts |= std::bit_cast<std::int64_t>(kSure) - std::bit_cast<std::int64_t>(rest);
  }
  if (doubts >= 0) return;
  for (std::size_t i = 0; i < count; ++i) numbers[i] = floor_to_int(x_m[i] / cell_m);
}

}  // namespace

void cell_keys(std::span<const Eigen::Vector3d> points_m, double cell_m, std::span<CellKey> keys) {
  constexpr std::size_t kBlock = 32;
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  static_assert(sizeof(CellKey) == 3 * sizeof(std::int32_t));
  SIGHTLINE_CHECK(points_m.size() == keys.size());
  for (std::size_t first = 0; first < points_m.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, points_m.size() - first);
    floor_quotients(points_m[first].data(), 3 * count, cell_m, &keys[first].x);
  }
}

std::size_t find_runs(std::span<const CellKey> keys, std::span<CellRun> runs) {
  SIGHTLINE_CHECK(runs.size() >= keys.size());
  if (keys.empty()) return 0;
  // Without a branch, since where a run ends cannot be predicted: each key is written as the next
  // run's, which then counts or not.
  runs[0] = {keys[0], 0, 0};
  std::size_t count = 1;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    runs[count] = {keys[i], static_cast<std::uint32_t>(i), 0};
    count += is_same(keys[i], keys[i - 1]) ? 0 : 1;
  }
  for (std::size_t r = 0; r + 1 < count; ++r) runs[r].count = runs[r + 1].begin - runs[r].begin;
  CellRun& last = runs[count - 1];
  last.count = static_cast<std::uint32_t>(keys.size()) - last.begin;
  return count;
}

std::uint32_t CellIndex::add_new(Slot& slot, const CellKey& key) {
  const auto number = static_cast<std::uint32_t>(keys_.size());
  slot = {key, number};
  keys_.push_back(key);
  if (2 * keys_.size() > slots_.size()) grow(4 * slots_.size());
  return number;
}

void CellIndex::reserve(std::size_t count) {
  keys_.reserve(count);
  if (2 * count > slots_.size()) grow(std::bit_ceil(2 * count));
}

void CellIndex::clear() {
  keys_.clear();
  slots_.assign(std::max(slots_.size(), std::size_t{1}), Slot{});  // none after a move
}

void CellIndex::grow(std::size_t slot_count) {
  constexpr std::size_t kFewest = 64;
  HugeVector<Slot>(std::max(slot_count, kFewest)).swap(slots_);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    slots_[slot_of(keys_[i])] = {keys_[i], static_cast<std::uint32_t>(i)};
  }
}

}  // namespace sightline
