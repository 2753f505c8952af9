#include "formats/tables/stored_table.h"

namespace sightline::stored_table {

Error in_tile(Error error, const TileKey& tile) {
  error.place = "tile " + std::to_string(tile.x) + ", " + std::to_string(tile.y) +
                (error.place.empty() ? "" : ", ") + error.place;
  return error;
}

Error from_site(Error error, std::uint64_t first) {
  if (first > 0) error.place = "from site " + std::to_string(first) + " on, " + error.place;
  return error;
}

}  // namespace sightline::stored_table
