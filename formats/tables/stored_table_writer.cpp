#include "formats/tables/stored_table_writer.h"

namespace sightline::stored_table {

std::size_t run_length(std::span<const std::size_t> sites, std::size_t i) {
  std::size_t length = 1;
  while (i + length < sites.size() && length < kRowsAtOnce &&
         sites[i + length] == sites[i] + length) {
    ++length;
  }
  return length;
}

}  // namespace sightline::stored_table
