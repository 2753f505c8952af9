#include "passes/matching/grid/packed_records.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "formats/base/check.h"

// In a plane of NDs a cell of the plane has five lanes in use, and each cell beside the plane one.
//
// The kernel sums the terms of eight lanes as a balanced tree: ((0 1) (2 3)) ((4 5) (6 7)). An
// empty lane adds an exact 0, and a + b = b + a to the bit. So lanes may move as long as those in
// use are joined in the same order: of two halves, either may come first, and where one is empty
// the other takes the place of both.

namespace sightline {
namespace {

constexpr std::size_t kLanes = 8;
constexpr std::uint8_t kEmptyLane = kLanes - 1;  // of every record

struct Packing {
  std::size_t lane_count = 0;
  std::array<std::uint8_t, kLanes> lanes{};  // of the whole record, by those of the packed one
};

constexpr Packing join(const Packing& left, const Packing& right) {
  Packing joined = left.lane_count >= right.lane_count ? left : right;
  const Packing& smaller = left.lane_count >= right.lane_count ? right : left;
  if (smaller.lane_count == 0) return joined;
  const std::size_t begin = std::bit_ceil(joined.lane_count);
  std::fill(joined.lanes.begin() + static_cast<std::ptrdiff_t>(joined.lane_count),
            joined.lanes.begin() + static_cast<std::ptrdiff_t>(begin), kEmptyLane);
  std::copy_n(smaller.lanes.begin(), smaller.lane_count,
              joined.lanes.begin() + static_cast<std::ptrdiff_t>(begin));
  joined.lane_count = begin + smaller.lane_count;
  return joined;
}

constexpr Packing packing_of(unsigned used_lanes) {
  std::array<Packing, kLanes> parts{};
  for (std::uint8_t lane = 0; lane < kLanes; ++lane) {
    if ((used_lanes >> lane & 1u) != 0) parts[lane] = {1, {lane}};
  }
  for (std::size_t count = kLanes; count > 1; count /= 2) {
    for (std::size_t i = 0; i < count / 2; ++i) parts[i] = join(parts[2 * i], parts[2 * i + 1]);
  }
  if (parts[0].lane_count == 0) return {1, {kEmptyLane}};
  return parts[0];
}

constexpr std::array<Packing, 1u << kEmptyLane> kPackings = [] {
  std::array<Packing, 1u << kEmptyLane> packings{};
  for (unsigned used = 0; used < packings.size(); ++used) packings[used] = packing_of(used);
  return packings;
}();

// Rows of eight floats are read: this many floats follow the last record.
constexpr std::size_t kFloatsBeyond = kLanes - 1;
constexpr std::size_t kFloatsOfWhole = kLanes * kRecordRows;
static_assert(sizeof(KernelRecord) == kFloatsOfWhole * sizeof(float));

std::size_t end_of(const MappedVector<KernelPlace>& places) {
  return places.empty() ? 0 : places.back().begin + lane_count(places.back());
}

KernelPlace place_at(std::size_t begin, std::size_t lanes) {
  constexpr std::size_t kMost = std::size_t{1} << 29;
  SIGHTLINE_CHECK(begin < kMost);  // 19 GB of records
  KernelPlace place{};
  place.begin = static_cast<std::uint32_t>(begin) & (kMost - 1);
  place.lanes_beyond_one = static_cast<std::uint32_t>(lanes - 1) & 7u;
  return place;
}

}  // namespace

void PackedRecords::reserve(std::size_t count) {
  memory.reserve(count + 1);  // what is not used is never touched
  places.reserve(count);
}

void PackedRecords::append(const KernelRecord& record, unsigned used_lanes) {
  const Packing& packing = kPackings[used_lanes];
  const std::size_t begin = end_of(places);
  const std::size_t end = begin + packing.lane_count;
  const std::size_t float_count = kRecordRows * end + kFloatsBeyond;
  memory.resize((float_count + kFloatsOfWhole - 1) / kFloatsOfWhole);
  places.push_back(place_at(begin, packing.lane_count));
  const auto* from = reinterpret_cast<const float*>(&record);
  float* to = reinterpret_cast<float*>(memory.data()) + kRecordRows * begin;
  for (std::size_t row = 0; row < kRecordRows; ++row, from += kLanes) {
    for (std::size_t i = 0; i < packing.lane_count; ++i) *to++ = from[packing.lanes[i]];
  }
}

void PackedRecords::append_whole(const KernelRecord& record) {
  places.push_back(place_at(kLanes * memory.size(), kLanes));
  memory.push_back(record);
}

}  // namespace sightline
