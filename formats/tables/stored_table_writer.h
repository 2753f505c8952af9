#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/check.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// Makes a table: of tiles row after row, of sites in any order.
template <HasRows X>
class StoredTableWriter {
 public:
  // In memory as far as they are few: a kilometre or two.
  static constexpr std::size_t kMostInMemory = std::size_t{4} << 20;
  // `head`: all but the rows. Those of sites are zero until they are put.
  explicit StoredTableWriter(const X& head, std::size_t most_in_memory = kMostInMemory);

  // The next rows. Tiles ascend, and so do rows within a tile. Errors: disk-full, cannot-write.
  [[nodiscard]] Result<void> append(const X& rows) requires HasTiles<X>;
  // The rows of some sites, in their order. Safe from several threads. take() returns its errors.
  void put(std::span<const std::size_t> sites, const X& rows) requires(!HasTiles<X>);
  // Of consecutive sites.
  void put(std::size_t first, const X& rows) requires(!HasTiles<X>);
  // All, once. Errors: disk-full, cannot-write.
  [[nodiscard]] Result<StoredTable<X>> take();

 private:
  StoredTable<X> made_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  GrowingBytes bytes_;
  Result<void> written_;
};

template <HasRows X>
StoredTableWriter<X>::StoredTableWriter(const X& head, std::size_t most_in_memory)
    : bytes_(most_in_memory) {
  made_.head_ = RowsOf<X>::head_of(head);
  if constexpr (!HasTiles<X>) {
    made_.row_count_ = RowsOf<X>::count(head);
    const std::size_t size = RowsOf<X>::size(head);
    const std::vector<std::byte> zeros(kRowsAtOnce * size);
    written_ = stored_table::visit_stretches(
        made_.row_count_, [&](std::size_t /*first*/, std::size_t count) {
          return bytes_.append(std::span(zeros).first(count * size));
        });
  }
}

template <HasRows X>
Result<void> StoredTableWriter<X>::append(const X& rows) requires HasTiles<X> {
  return stored_table::visit_stretches(RowsOf<X>::count(rows),
                                       [&](std::size_t first, std::size_t count) {
                                         ByteWriter writer;
                                         RowsOf<X>::encode(rows, first, count, writer);
                                         made_.add_to_tiles(writer.bytes());
                                         made_.row_count_ += count;
                                         return bytes_.append(writer.bytes());
                                       });
}

template <HasRows X>
void StoredTableWriter<X>::put(std::span<const std::size_t> sites,
                               const X& rows) requires(!HasTiles<X>) {
  const std::size_t size = RowsOf<X>::size(made_.head_);
  SIGHTLINE_CHECK(RowsOf<X>::count(rows) == sites.size() && RowsOf<X>::size(rows) == size);
  for (std::size_t i = 0; i < sites.size();) {
    const std::size_t count = stored_table::run_length(sites, i);
    SIGHTLINE_CHECK(sites[i] + count <= made_.row_count_);
    ByteWriter writer;
    RowsOf<X>::encode(rows, i, count, writer);
    const std::lock_guard<std::mutex> lock(*mutex_);
    if (written_) written_ = bytes_.replace(sites[i] * size, writer.bytes());
    i += count;
  }
}

template <HasRows X>
void StoredTableWriter<X>::put(std::size_t first, const X& rows) requires(!HasTiles<X>) {
  std::vector<std::size_t> sites(RowsOf<X>::count(rows));
  std::iota(sites.begin(), sites.end(), first);
  put(sites, rows);
}

template <HasRows X>
Result<StoredTable<X>> StoredTableWriter<X>::take() {
  SIGHTLINE_TRY(written_);
  made_.rows_ = bytes_.take();
  return std::move(made_);
}

}  // namespace sightline
