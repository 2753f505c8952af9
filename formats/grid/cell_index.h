#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/base/huge_pages.h"
#include "formats/grid/cell_key.h"

// Cells of many points at once, and tables of cells: shared by all code that sorts points into a
// grid.

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

// Numbers cells 0, 1, 2, ... in the order in which they are first met: open addressing with linear
// probing, at most half full, the key beside the number so that one look finds both. Holds at most
// 2^31 cells. Reading is safe from several threads.
class CellIndex {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  CellIndex() : slots_(1) {}

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

  // Takes memory for this many cells.
  void reserve(std::size_t count);
  // Without a cell again, the memory kept for the next.
  void clear();

 private:
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
  void grow(std::size_t slot_count);

  // A power of two of them. One that is free from the start: so no look asks whether there is any.
  HugeVector<Slot> slots_;
  std::vector<CellKey> keys_;
};

// A value for each cell, numbered as a CellIndex does. `Value` is default constructible.
template <class Value>
class CellTable {
 public:
  static constexpr std::uint32_t kNone = CellIndex::kNone;

  struct Inserted {
    std::uint32_t number = 0;
    bool is_new = false;
  };

  // The number of a cell; one that is not there yet is added with `value`. References to values
  // then hold no longer.
  Inserted insert(const CellKey& key, const Value& value = {}) {
    const std::uint32_t number = index_.add(key);
    const bool is_new = number == values_.size();
    if (is_new) values_.push_back(value);
    return {number, is_new};
  }

  // Calls add(value of the run's cell, run) for each run, in their order. Points in random order
  // find neither their cell nor its value in the cache: both are asked for ahead.
  template <class Add>
  void add(std::span<const CellRun> runs, const Add& add) {
    constexpr std::size_t kAhead = 12;
    numbers_.resize(runs.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (i + kAhead < runs.size()) index_.prefetch(runs[i + kAhead].key);
      numbers_[i] = index_.add(runs[i].key);
    }
    values_.resize(index_.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (i + kAhead < runs.size()) prefetch(values_[numbers_[i + kAhead]]);
      add(values_[numbers_[i]], runs[i]);
    }
  }

  // kNone for a cell that is not there.
  [[nodiscard]] std::uint32_t number_of(const CellKey& key) const { return index_.find(key); }
  // nullptr for a cell that is not there.
  [[nodiscard]] const Value* find(const CellKey& key) const {
    const std::uint32_t number = number_of(key);
    return number == kNone ? nullptr : &values_[number];
  }
  [[nodiscard]] Value* find(const CellKey& key) {
    const std::uint32_t number = number_of(key);
    return number == kNone ? nullptr : &values_[number];
  }
  void prefetch(const CellKey& key) const { index_.prefetch(key); }

  // By number.
  [[nodiscard]] const std::vector<CellKey>& keys() const { return index_.keys(); }
  [[nodiscard]] std::span<const Value> values() const { return values_; }
  [[nodiscard]] std::span<Value> values() { return values_; }

  [[nodiscard]] std::size_t size() const { return index_.size(); }
  [[nodiscard]] bool empty() const { return size() == 0; }

  // Takes memory for this many cells, so that no value is moved until there are more.
  void reserve(std::size_t count) {
    index_.reserve(count);
    values_.reserve(count);
  }
  // Without a cell again, the memory kept for the next.
  void clear() {
    index_.clear();
    values_.clear();
  }

 private:
  // A value may lie in two lines of the cache.
  static void prefetch(const Value& value) {
    const char* begin = reinterpret_cast<const char*>(&value);
    __builtin_prefetch(begin, 1);
    __builtin_prefetch(begin + sizeof(Value) - 1, 1);
  }

  CellIndex index_;
  std::vector<Value> values_;
  std::vector<std::uint32_t> numbers_;  // of the runs being added
};

// A set of cells that is mostly asked for others: one bit, which the cache holds, answers for 15 of
// 16 of these that they are not there, where a look into a table waits for memory. Safe to ask from
// several threads.
class CellSet {
 public:
  explicit CellSet(std::span<const CellKey> cells)
      : bits_(std::bit_ceil(kBitsPerCell * (cells.size() + 4)) / 64) {
    for (const CellKey& cell : cells) {
      index_.add(cell);
      bits_[word_of(cell)] |= bit_of(cell);
    }
  }

  [[nodiscard]] bool contains(const CellKey& cell) const {
    return (bits_[word_of(cell)] & bit_of(cell)) != 0 && index_.find(cell) != CellIndex::kNone;
  }
  [[nodiscard]] bool empty() const { return index_.size() == 0; }

 private:
  static constexpr std::size_t kBitsPerCell = 16;

  [[nodiscard]] std::size_t word_of(const CellKey& cell) const {
    return (hash_of(cell) >> 6) & (bits_.size() - 1);
  }
  static std::uint64_t bit_of(const CellKey& cell) {
    return std::uint64_t{1} << (hash_of(cell) & 63);
  }

  std::vector<std::uint64_t> bits_;  // a power of two of words
  CellIndex index_;
};

}  // namespace sightline
