#pragma once

#include "passes/matching/grid/mapped_allocator.h"
#include "passes/matching/kernel/match_kernel.h"

namespace sightline {

// Records of a grid, one behind the other. Those of a grid that is made at once have as few lanes
// as give the bits of all eight, in a third of the memory.
struct PackedRecords {
  // In units of whole records. After the last record there are seven floats or more.
  MappedVector<KernelRecord> memory;
  MappedVector<KernelPlace> places;  // by number

  [[nodiscard]] const float* floats() const {
    return reinterpret_cast<const float*>(memory.data());
  }
  void reserve(std::size_t count);
  // Bit i of `used_lanes`: whether lane i has an ND. The eighth never has one.
  void append(const KernelRecord& record, unsigned used_lanes);
  // In all eight lanes, as memory[number of the record], so that lanes can change. Only for records
  // that are all appended in this way.
  void append_whole(const KernelRecord& record);
};

}  // namespace sightline
