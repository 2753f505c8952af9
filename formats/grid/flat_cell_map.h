#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "formats/grid/cell_index.h"

namespace sightline {

// A value for each cell of a grid, in a flat hash table: open addressing with linear probing, at
// most half full, the key beside the number of its value so that one look finds both. Cells are
// numbered 0, 1, 2, ... in the order of insertion, which is the order of keys() and values(); none
// is ever removed but all at once. Holds at most 2^31 cells. Reading is safe from several threads.
template <class Value>
class FlatCellMap {
  static_assert(std::is_default_constructible_v<Value> && std::is_copy_constructible_v<Value>);

 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  struct Inserted {
    std::uint32_t number = 0;
    bool is_new = false;
  };

  // The number of a cell; one that is not there yet is added with `value`. References to values
  // then hold no longer.
  Inserted insert(const CellKey& key, const Value& value = {}) {
    if (2 * (keys_.size() + 1) > slots_.size()) grow(2 * slots_.size());
    Slot& slot = slots_[slot_of(key)];
    if (slot.number != kNone) return {slot.number, false};
    slot = {key, static_cast<std::uint32_t>(keys_.size())};
    keys_.push_back(key);
    values_.push_back(value);
    return {slot.number, true};
  }

  // kNone for a cell that is not there.
  [[nodiscard]] std::uint32_t number_of(const CellKey& key) const {
    return slots_.empty() ? kNone : slots_[slot_of(key)].number;
  }
  // nullptr for a cell that is not there.
  [[nodiscard]] const Value* find(const CellKey& key) const {
    const std::uint32_t number = number_of(key);
    return number == kNone ? nullptr : &values_[number];
  }
  [[nodiscard]] Value* find(const CellKey& key) {
    const std::uint32_t number = number_of(key);
    return number == kNone ? nullptr : &values_[number];
  }

  // Brings the place of a key that is soon asked for nearer.
  void prefetch(const CellKey& key) const {
    if (!slots_.empty()) __builtin_prefetch(&slots_[hash_of(key) & (slots_.size() - 1)]);
  }

  // By number.
  [[nodiscard]] std::span<const CellKey> keys() const { return keys_; }
  [[nodiscard]] std::span<const Value> values() const { return values_; }
  [[nodiscard]] std::span<Value> values() { return values_; }

  [[nodiscard]] std::size_t size() const { return keys_.size(); }
  [[nodiscard]] bool empty() const { return keys_.empty(); }

  // Takes memory for this many cells, so that none is moved until there are more.
  void reserve(std::size_t count) {
    keys_.reserve(count);
    values_.reserve(count);
    if (2 * count > slots_.size()) grow(std::bit_ceil(2 * count));
  }

  // Without a cell again, the memory kept for the next.
  void clear() {
    keys_.clear();
    values_.clear();
    slots_.assign(slots_.size(), Slot{});
  }

 private:
  static constexpr std::size_t kFirstSize = 64;  // slots; a power of two, as every size
  struct Slot {
    CellKey key;
    std::uint32_t number = kNone;
  };

  // Where the key is, or the free slot where it belongs. There is at least one slot.
  [[nodiscard]] std::size_t slot_of(const CellKey& key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash_of(key) & mask;
    while (slots_[slot].number != kNone && slots_[slot].key != key) slot = (slot + 1) & mask;
    return slot;
  }

  void grow(std::size_t size) {
    slots_.assign(size < kFirstSize ? kFirstSize : size, Slot{});
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      slots_[slot_of(keys_[i])] = {keys_[i], static_cast<std::uint32_t>(i)};
    }
  }

  std::vector<Slot> slots_;
  std::vector<CellKey> keys_;
  std::vector<Value> values_;
};

}  // namespace sightline
