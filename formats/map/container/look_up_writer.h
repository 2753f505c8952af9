#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/reader/map_layout.h"

namespace sightline {

using BlockKinds = std::set<std::pair<std::string, std::uint32_t>>;  // names and versions

// Makes the section "look-up" of a map from its range layers (schemas/map_format.md). Equal layers
// in any order give equal bytes.
class LookUpBuilder {
 public:
  // The numbers are within the bounds of the format; the map's reach.
  LookUpBuilder(const AnswerShape& shape, double reach_m);

  // A raw range layer. False, and no look-up can be made any more, where it has not the size that
  // its rows need, a row takes a range that there is not, or lies nowhere. At most kMostRows.
  bool add(std::span<const std::byte> raw, std::uint64_t row_count);

  // Needs the root digest of the header, and what blocks of the file are required. Empty where no
  // look-up can be made: no rows, rows that could not be added, or too many kinds of blocks.
  [[nodiscard]] std::vector<std::byte> finish(const FileHeader& header,
                                              const BlockKinds& required) const;

 private:
  struct Place {
    std::int32_t x = 0;  // the cell's key
    std::int32_t y = 0;
    std::uint32_t site = 0;
    std::uint64_t offset = 0;  // of the row in rows_
    auto operator<=>(const Place&) const = default;
  };

  // Copies what a row's choices say; false where a choice is none.
  bool add_choices(std::span<const std::byte> raw, const RangeLayout& from, std::uint64_t row,
                   std::byte* out) const;

  AnswerShape shape_;
  double cell_m_;
  std::vector<Place> places_;
  std::vector<std::byte> rows_;
  bool is_possible_ = true;
};

}  // namespace sightline
