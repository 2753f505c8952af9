#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/base/huge_pages.h"
#include "formats/grid/cell_key.h"

// Finding the cells of many points at once: shared by all code that sorts points into a grid.

namespace sightline {

// keys[i] = cell_key(points_m[i], cell_m), to the bit, several points at a time. Each coordinate
// must lie within 2^31 cells of the origin. As many keys as points.
void cell_keys(std::span<const Eigen::Vector3d> points_m, double cell_m, std::span<CellKey> keys);

// Consecutive points of one cell: most points of a scan share their cell with the one before.
struct CellRun {
  CellKey key;
  std::uint32_t begin = 0;
  std::uint32_t count = 0;
};

// Writes the longest runs of equal keys, `begin` counted from the first key, and returns their
// number. Takes as many runs as keys to work with, and at most 2^32 keys.
std::size_t find_runs(std::span<const CellKey> keys, std::span<CellRun> runs);

// Numbers cells 0, 1, 2, ... in the order in which they are first met: open addressing, at most
// half full, the key beside the number so that one look finds both.
class CellIndex {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  CellIndex() : slots_(kFirstSize) {}

  // The cell's number; one not met before gets the next.
  std::uint32_t add(const CellKey& key) {
    Slot& slot = slots_[slot_of(key)];
    if (slot.number != kNone) return slot.number;
    return add_new(slot, key);
  }

  // kNone for a cell never met.
  [[nodiscard]] std::uint32_t find(const CellKey& key) const { return slots_[slot_of(key)].number; }

  // Brings the place of a key that is soon asked for nearer.
  void prefetch(const CellKey& key) const { __builtin_prefetch(&slots_[first_slot(key)]); }

  // By number.
  [[nodiscard]] const std::vector<CellKey>& keys() const { return keys_; }
  [[nodiscard]] std::size_t size() const { return keys_.size(); }

 private:
  static constexpr std::size_t kFirstSize = 4096;
  struct Slot {
    CellKey key;
    std::uint32_t number = kNone;
  };

  [[nodiscard]] std::size_t first_slot(const CellKey& key) const {
    return hash_of(key) & (slots_.size() - 1);
  }
  // Where the key is, or the free slot where it belongs.
  [[nodiscard]] std::size_t slot_of(const CellKey& key) const {
    std::size_t slot = first_slot(key);
    while (slots_[slot].number != kNone && slots_[slot].key != key) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    return slot;
  }
  std::uint32_t add_new(Slot& slot, const CellKey& key);
  void grow();

  HugeVector<Slot> slots_;
  std::vector<CellKey> keys_;
};

// What is summed over the points of each cell. `Sums` is default constructible: no point yet.
template <class Sums>
class CellTable {
 public:
  // Calls add(sums of the run's cell, run) for each run, in their order. Points in random order
  // find neither their cell nor its sums in the cache: both are asked for ahead.
  template <class Add>
  void add(std::span<const CellRun> runs, const Add& add) {
    constexpr std::size_t kAhead = 12;
    numbers_.resize(runs.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (i + kAhead < runs.size()) index_.prefetch(runs[i + kAhead].key);
      numbers_[i] = index_.add(runs[i].key);
    }
    sums_.resize(index_.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (i + kAhead < runs.size()) prefetch(sums_[numbers_[i + kAhead]]);
      add(sums_[numbers_[i]], runs[i]);
    }
  }

  // By number, in the order in which cells were first met.
  [[nodiscard]] const std::vector<CellKey>& keys() const { return index_.keys(); }
  [[nodiscard]] const std::vector<Sums>& sums() const { return sums_; }

 private:
  // The sums may lie in two lines of the cache.
  static void prefetch(const Sums& sums) {
    const char* begin = reinterpret_cast<const char*>(&sums);
    __builtin_prefetch(begin, 1);
    __builtin_prefetch(begin + sizeof(Sums) - 1, 1);
  }

  CellIndex index_;
  std::vector<Sums> sums_;
  std::vector<std::uint32_t> numbers_;  // of the runs being added
};

}  // namespace sightline
