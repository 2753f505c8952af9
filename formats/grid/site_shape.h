#pragma once

#include <cstddef>

namespace sightline {

// The order of numbers that every site has several of, in one vector: [site][row][column], the last
// index fastest. Rows are ranges (or limits, in tables of choices), columns limits or factors.
struct SiteShape {
  std::size_t rows = 1;  // of each site
  std::size_t columns = 1;

  [[nodiscard]] std::size_t index(std::size_t site, std::size_t row, std::size_t column = 0) const {
    return (site * rows + row) * columns + column;
  }
  // Where the numbers of a site begin, or how many those of so many sites are.
  [[nodiscard]] std::size_t size(std::size_t sites) const { return sites * rows * columns; }

  // The way back. At least one row and one column.
  [[nodiscard]] std::size_t site_of(std::size_t index) const { return index / (rows * columns); }
  [[nodiscard]] std::size_t row_of(std::size_t index) const { return index / columns % rows; }
  [[nodiscard]] std::size_t column_of(std::size_t index) const { return index % columns; }
};

}  // namespace sightline
