#include "compiler/views/exports/scan_blocks.h"

namespace sightline {
namespace {

constexpr int kBlockShift = 2;  // 4 voxels
constexpr int kChunkShift = 4;  // 16 voxels
constexpr int kBlockBits = 6;   // of a place: its voxel in the block
constexpr int kChunkBits = 12;  // of a place: its voxel in the chunk
// Rounding takes a ray past its end by less than a voxel.
constexpr std::int32_t kMargin_voxels = 2;

// What a coordinate within a block adds to the bit, as an octree's children are ordered.
std::uint64_t bit_part(std::int32_t coordinate, int axis) {
  const auto low = static_cast<std::uint64_t>(coordinate & 1);
  const auto high = static_cast<std::uint64_t>(coordinate >> 1 & 1);
  return low << axis | high << (axis + 3);
}

}  // namespace

int child_of_parent(const CellKey& cell) {
  return (cell.x & 1) | (cell.y & 1) << 1 | (cell.z & 1) << 2;
}

CellKey block_of_chunk(const CellKey& chunk, std::size_t number) {
  const auto n = static_cast<std::int32_t>(number);
  return {4 * chunk.x + (n & 3), 4 * chunk.y + (n >> 2 & 3), 4 * chunk.z + (n >> 4)};
}

void ScanBlocks::begin(const CellKey& low, const CellKey& high) {
  for (const std::uint64_t place : places_) number_of_chunk_[place >> kChunkBits] = 0;
  places_.clear();
  chunks_.clear();
  const std::array<std::int32_t, 3> lows = {low.x, low.y, low.z};
  const std::array<std::int32_t, 3> highs = {high.x, high.y, high.z};
  std::uint64_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const std::int32_t first_chunk = (lows[a] - kMargin_voxels) >> kChunkShift;
    const std::int32_t end_chunk = ((highs[a] + kMargin_voxels) >> kChunkShift) + 1;
    first_[a] = first_chunk << kChunkShift;
    parts_[a].clear();
    for (std::int32_t v = 0; v < (end_chunk - first_chunk) << kChunkShift; ++v) {
      const std::uint64_t block = static_cast<std::uint64_t>(v >> kBlockShift & 3) << (2 * axis);
      const std::uint64_t chunk = static_cast<std::uint64_t>(v >> kChunkShift) * stride;
      parts_[a].push_back(chunk << kChunkBits | block << kBlockBits | bit_part(v, axis));
    }
    size_[a] = static_cast<std::uint64_t>(end_chunk - first_chunk);
    stride *= size_[a];
  }
  if (number_of_chunk_.size() < stride) number_of_chunk_.resize(stride, 0);
}

std::uint64_t ScanBlocks::place_of(const CellKey& voxel) const {
  return parts_[0][static_cast<std::size_t>(voxel.x - first_[0])] +
         parts_[1][static_cast<std::size_t>(voxel.y - first_[1])] +
         parts_[2][static_cast<std::size_t>(voxel.z - first_[2])];
}

ChunkVoxels& ScanBlocks::chunk_of(std::uint64_t place) {
  const std::uint64_t in_box = place >> kChunkBits;
  std::uint32_t& number = number_of_chunk_[in_box];
  if (number == 0) {
    const auto axis = [&](std::size_t a, std::uint64_t in_axis) {
      return (first_[a] >> kChunkShift) + static_cast<std::int32_t>(in_axis % size_[a]);
    };
    chunks_.push_back(
        {{axis(0, in_box), axis(1, in_box / size_[0]), axis(2, in_box / (size_[0] * size_[1]))}});
    places_.push_back(place);
    number = static_cast<std::uint32_t>(chunks_.size());
  }
  return chunks_[number - 1];
}

void ScanBlocks::occupy(const CellKey& voxel) {
  const std::uint64_t place = place_of(voxel);
  chunk_of(place).blocks[place >> kBlockBits & 63U].occupied |= std::uint64_t{1} << (place & 63U);
}

// Beams of one scan follow each other closely, so that processors predict the branches well.
void ScanBlocks::free_along(const VoxelRay& ray) {
  struct Axis {
    const std::uint64_t* part;
    std::ptrdiff_t step;
    double next_m;
    double between_m;
  };
  const auto axis_of = [&](std::size_t a, std::int32_t voxel) -> Axis {
    return {&parts_[a][static_cast<std::size_t>(voxel - first_[a])], ray.step[a], ray.next_m[a],
            ray.between_m[a]};
  };
  const auto advance = [](Axis& axis) {
    axis.part += axis.step;
    axis.next_m += axis.between_m;
  };
  Axis x = axis_of(0, ray.from.x);
  Axis y = axis_of(1, ray.from.y);
  Axis z = axis_of(2, ray.from.z);
  const std::uint64_t end = place_of(ray.to);
  std::uint64_t place = place_of(ray.from);
  std::uint64_t known = place;  // of the chunk
  ChunkVoxels* chunk = &chunk_of(place);
  do {
    if ((place ^ known) >> kChunkBits != 0) {
      chunk = &chunk_of(place);
      known = place;
    }
    chunk->blocks[place >> kBlockBits & 63U].free |= std::uint64_t{1} << (place & 63U);
    if (x.next_m < y.next_m && x.next_m < z.next_m) {
      advance(x);
    } else if (x.next_m >= y.next_m && y.next_m < z.next_m) {
      advance(y);
    } else {
      advance(z);
    }
    place = *x.part + *y.part + *z.part;
  } while (place != end &&
           (x.next_m <= ray.length_m || y.next_m <= ray.length_m || z.next_m <= ray.length_m));
}

}  // namespace sightline
