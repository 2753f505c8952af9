#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "formats/base/result.h"
#include "formats/reader/opened_map.h"

// The section "look-up" of a compiled map (schemas/map_format.md): sites by place, in pages that
// check themselves, so that one look-up touches a few pages of a file of any size.

namespace sightline {

inline constexpr std::size_t kPageSize = 4096;
inline constexpr std::size_t kPagePayload = kPageSize - 16;  // then its number and its checksum

// One cell of the hash table in the first pages.
struct LookUpSlot {
  std::int32_t x = 0;  // the cell's key: floor(coordinate / cell_m)
  std::int32_t y = 0;
  std::uint32_t first_row = 0;
  std::uint32_t row_count = 0;  // 0: an empty slot
};
inline constexpr std::uint64_t kSlotsPerPage = kPagePayload / sizeof(LookUpSlot);

// Where the search for a cell begins; it goes on slot by slot, around the end, to an empty one.
constexpr std::uint64_t first_slot(std::int32_t x, std::int32_t y, std::uint64_t slot_count) {
  const std::uint64_t key =
      std::uint64_t{static_cast<std::uint32_t>(x)} << 32 | static_cast<std::uint32_t>(y);
  return ((key * 0x9E3779B97F4A7C15ULL) >> 32) * slot_count >> 32;
}

// Where each field of a row begins. In a small map lengths are whole multiples of kSmallLength_m
// and probabilities of kSmallShare: i32 for places, u16 for the others.
struct LookUpRowLayout {
  explicit LookUpRowLayout(const AnswerShape& shape)
      : is_small(shape.is_small),
        value_size(is_small ? 2 : 8),
        longest_error(is_small ? 12 : 24),
        site(is_small ? 16 : 32),
        probability(is_small ? 20 : 40),
        mean_error(probability + value_size * shape.limits),
        look_probability(mean_error + value_size * shape.limits),
        look_mean_error(look_probability + value_size * look_limits(shape)),
        range_index(look_mean_error + value_size * look_limits(shape)),
        range_flags(range_index + shape.limits),
        look_index(range_flags + shape.limits),
        look_flags(look_index + look_limits(shape)),
        range_reason(look_flags + look_limits(shape)),
        look_reason(range_reason + shape.limits),
        size((look_reason + look_limits(shape) + row_step() - 1) / row_step() * row_step()),
        rows_per_page(kPagePayload / size) {}

  [[nodiscard]] double place_m(const std::byte* row, std::size_t axis) const;
  [[nodiscard]] double length_m(const std::byte* row, std::uint64_t field, std::size_t i) const;
  [[nodiscard]] double share(const std::byte* row, std::uint64_t field, std::size_t i) const;
  // Of a small map: rounded to the nearest multiple.
  void put_place(std::byte* row, std::size_t axis, double value_m) const;
  void put_length(std::byte* row, std::uint64_t field, std::size_t i, double value_m) const;
  void put_share(std::byte* row, std::uint64_t field, std::size_t i, double value) const;

  bool is_small;
  std::uint64_t value_size;
  std::uint64_t longest_error;  // at the longest range
  std::uint64_t site;           // u32
  std::uint64_t probability;    // [limits], at the chosen range
  std::uint64_t mean_error;     // [limits], at the chosen range
  // What begins with "look" is of the looks that take a sample, and empty where there are none.
  std::uint64_t look_probability;  // [limits], at the chosen look
  std::uint64_t look_mean_error;   // [limits]
  std::uint64_t range_index;       // u8[limits]
  std::uint64_t range_flags;       // u8[limits]
  std::uint64_t look_index;        // u8[limits]
  std::uint64_t look_flags;        // u8[limits]
  std::uint64_t range_reason;      // u8[limits]
  std::uint64_t look_reason;       // u8[limits]
  std::uint64_t size;
  std::uint64_t rows_per_page;

 private:
  static std::uint64_t look_limits(const AnswerShape& shape) {
    return shape.looks > 0 ? shape.limits : 0;
  }
  [[nodiscard]] std::uint64_t row_step() const { return is_small ? 4 : 8; }
};

// The last page: what the others are.
struct LookUpInfo {
  std::uint64_t page_count = 0;  // this page is the last of them
  double cell_m = 0.0;
  std::uint64_t slot_count = 0;
  std::uint64_t row_count = 0;
  std::uint32_t limit_count = 0;
  std::uint32_t look_count = 0;
  bool is_small = false;        // the rows
  std::string required_blocks;  // lines "name version", ascending: what a reader must know
};
inline constexpr std::size_t kMostRequiredText = kPagePayload - 64;

// Pages of slots, then pages of rows, then this page.
std::uint64_t slot_page_count(const LookUpInfo& info);
std::uint64_t row_page_count(const LookUpInfo& info);

// `page` has kPageSize bytes, of which the payload is there. The seed comes from the root digest,
// so that no page of another map, or of another version of it, passes for one of this.
std::uint64_t page_seed(const FileHeader& header);
void seal_page(std::span<std::byte> page, std::uint64_t number, std::uint64_t seed);
void encode_look_up_info(const LookUpInfo& info, std::span<std::byte> page);

// The section, open for looking up. Safe to use from several threads at once; after open() it
// allocates nothing.
class LookUp {
 public:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  struct Nearest {
    const std::byte* row = nullptr;  // none within reach
    double distance2_m2 = 0.0;
    std::uint32_t site = 0;
    bool is_damaged = false;         // what was needed does not hold what it should
    std::uint64_t bad_page = kNone;  // a page with a wrong checksum
  };

  // Errors: out-of-bounds, checksum-mismatch, bad-layer, unknown-required-feature.
  static Result<LookUp> open(const MapFront& front);

  // The site nearest to a place in map coordinates, at most reach_m away and on its level
  // (is_same_level).
  [[nodiscard]] Nearest nearest(const std::array<double, 3>& p_m) const;

  // The row of that number, with its site and a distance of 0; none where it is damaged.
  [[nodiscard]] Nearest row(std::uint64_t number) const;

  // Errors: checksum-mismatch, bad-layer, at the byte of the page.
  [[nodiscard]] Error damage(const Nearest& nearest) const;

  [[nodiscard]] const LookUpRowLayout& row_layout() const { return row_layout_; }
  [[nodiscard]] std::uint64_t row_count() const { return row_count_; }

 private:
  LookUp(const MapFront& front, const LookUpInfo& info, std::uint64_t offset);
  const std::byte* page(std::uint64_t number, Nearest& nearest) const;
  void prefetch_cell(std::int32_t x, std::int32_t y) const;
  LookUpSlot find_cell(std::int32_t x, std::int32_t y, Nearest& nearest) const;
  void search_cell(std::int32_t x, std::int32_t y, const std::array<double, 3>& p_m,
                   Nearest& nearest) const;

  const std::byte* pages_ = nullptr;
  std::uint64_t offset_ = 0;  // of the section in the file
  std::uint64_t seed_ = 0;
  double reach_m_ = 0.0;
  double cell_m_ = 0.0;
  std::uint64_t slot_count_ = 0;
  std::uint64_t most_slots_ = 0;  // that a search visits
  std::uint64_t first_row_page_ = 0;
  std::uint64_t row_count_ = 0;
  LookUpRowLayout row_layout_;
  // Per page: whether it has been checked. Two threads may both check it.
  std::unique_ptr<std::atomic<std::uint8_t>[]> is_checked_;
};

}  // namespace sightline
