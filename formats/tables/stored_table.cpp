#include "formats/tables/stored_table.h"

namespace sightline::stored_table {

Error in_tile(Error error, const TileKey& tile) {
  error.place =
      concat("tile ", tile.x, ", ", tile.y, (error.place.empty() ? "" : ", "), error.place);
  return error;
}

Error from_site(Error error, std::uint64_t first) {
  if (first > 0) error.place = concat("from site ", first, " on, ", error.place);
  return error;
}

std::size_t run_length(std::span<const std::size_t> sites, std::size_t i) {
  std::size_t length = 1;
  while (i + length < sites.size() && length < kRowsAtOnce &&
         sites[i + length] == sites[i] + length) {
    ++length;
  }
  return length;
}

}  // namespace sightline::stored_table
