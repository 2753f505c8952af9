#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/artifact.h"
#include "formats/base/check.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/grid/cell_key.h"
#include "formats/tables/rows_of.h"

// Tables whose rows stay encoded, in memory or in a temporary file, and are read some at a time: a
// street of any length takes no more memory than a part of it. A table has the bytes of the struct
// X that holds all rows (formats/tables/rows_of.h).

namespace sightline {

// Rows of one tile, as places among all rows.
struct RowTile {
  TileKey key;
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

template <HasRows X>
class StoredTableWriter;

// An X whose rows stay encoded. Safe from several threads.
template <HasRows X>
class StoredTable {
 public:
  StoredTable() = default;
  // Converts implicitly from an X, whose rows stay in memory, in the order of a table.
  StoredTable(const X& whole);  // NOLINT(google-explicit-constructor)

  // All but the rows.
  [[nodiscard]] const X& head() const { return head_; }
  [[nodiscard]] std::uint64_t row_count() const { return row_count_; }
  // Encoded, one after another.
  [[nodiscard]] const StoredBytes& bytes() const { return rows_; }

  // Consecutive rows, within what there is, as an X of their own. Error: cannot-read, as of all
  // that follow.
  [[nodiscard]] Result<X> rows(std::uint64_t first, std::uint64_t count) const;
  [[nodiscard]] Result<X> whole() const;

  // Tiles that hold rows, ascending by key.
  [[nodiscard]] std::span<const RowTile> tiles() const { return tiles_; }
  [[nodiscard]] Result<X> tile(const RowTile& tile) const { return rows(tile.first, tile.count); }
  // The rows of all tiles that a box of the plane touches.
  [[nodiscard]] Result<X> over(const Eigen::AlignedBox2d& box_m) const;
  // How far any row reaches from its place along each axis; 0 without rows.
  [[nodiscard]] double reach_m() const { return reach_m_; }

  // The table of a payload, without the checks of validate(). Errors: cannot-read, bad-layer.
  static Result<StoredTable> open(const StoredBytes& payload);
  // What begins a payload: as many bytes as payload_size() of the table.
  static Result<StoredTable> open_front(const StoredBytes& payload);

 private:
  friend class StoredTableWriter<X>;

  [[nodiscard]] Result<void> find_tiles();
  // The next rows, encoded.
  void add_to_tiles(std::span<const std::byte> rows);
  // Fills rows of `into` from place `at` on.
  [[nodiscard]] Result<void> read(std::uint64_t first, std::uint64_t count, X& into,
                                  std::size_t at) const;

  X head_;
  std::uint64_t row_count_ = 0;
  StoredBytes rows_;
  std::vector<RowTile> tiles_;
  double reach_m_ = 0.0;
};

// A form of X.
template <HasRows X>
struct ArtifactTraits<StoredTable<X>> {
  using Artifact = X;
  static constexpr std::string_view kName = ArtifactTraits<X>::kName;
  static constexpr std::uint32_t kVersion = ArtifactTraits<X>::kVersion;
};

namespace stored_table {

Error in_tile(Error error, const TileKey& tile);
// Of sites from `first` on.
Error from_site(Error error, std::uint64_t first);

// How many consecutive sites follow the i-th, that one included.
std::size_t run_length(std::span<const std::size_t> sites, std::size_t i);

}  // namespace stored_table

// A table of sites may be large: a whole one is neither written nor read as one piece.
template <HasRows X>
requires(!HasTiles<X>) std::uint64_t payload_size(const X& whole) {
  const std::size_t count = RowsOf<X>::count(whole);
  return stored_table::head_bytes(whole, count).size() + count * RowsOf<X>::size(whole);
}

template <HasRows X>
requires(!HasTiles<X>) Result<void> visit_payload(const X& whole, const ByteSink& sink) {
  return visit_whole(whole, sink);
}

template <HasRows X>
requires(!HasTiles<X>) Result<void> open_payload(const StoredBytes& payload, X& whole) {
  SIGHTLINE_ASSIGN(const StoredTable<X> table, StoredTable<X>::open(payload));
  SIGHTLINE_ASSIGN(X found, table.whole());
  SIGHTLINE_TRY(validate(found));
  whole = std::move(found);
  return {};
}

// Reads all rows, some at a time.
template <HasRows X>
Result<void> validate(const StoredTable<X>& table) {
  for (std::uint64_t first = 0; first == 0 || first < table.row_count(); first += kRowsAtOnce) {
    SIGHTLINE_ASSIGN(const X some, table.rows(first, std::min<std::uint64_t>(
                                                         kRowsAtOnce, table.row_count() - first)));
    const Result<void> checked = validate(some);
    if (!checked) return stored_table::from_site(checked.error(), first);
  }
  return {};
}

template <HasTiles X>
Result<void> validate(const StoredTable<X>& table) {
  SIGHTLINE_TRY(validate(table.head()));
  const TileKey* before = nullptr;
  for (const RowTile& tile : table.tiles()) {
    SIGHTLINE_ASSIGN(const X rows, table.tile(tile));
    Result<void> checked = validate(rows);
    if (checked && before != nullptr && !(*before < tile.key)) {
      checked = Error{ErrorCode::kInvalidArtifact, "tiles must ascend"};
    }
    if (!checked) return stored_table::in_tile(checked.error(), tile.key);
    before = &tile.key;
  }
  return {};
}

// Error: cannot-read.
template <HasRows X>
Result<Table> dump(const StoredTable<X>& table) {
  SIGHTLINE_ASSIGN(const X whole, table.whole());
  return dump(whole);
}

template <HasRows X>
std::uint64_t payload_size(const StoredTable<X>& table) {
  return stored_table::head_bytes(table.head(), table.row_count()).size() + table.bytes().size();
}

template <HasRows X>
Result<void> visit_payload(const StoredTable<X>& table, const ByteSink& sink) {
  SIGHTLINE_TRY(sink(stored_table::head_bytes(table.head(), table.row_count())));
  return table.bytes().visit(sink);
}

template <HasRows X>
Result<void> open_payload(const StoredBytes& payload, StoredTable<X>& table) {
  SIGHTLINE_ASSIGN(StoredTable<X> opened, StoredTable<X>::open(payload));
  SIGHTLINE_TRY(validate(opened));
  table = std::move(opened);
  return {};
}

template <HasRows X>
StoredTable<X>::StoredTable(const X& whole)
    : head_(RowsOf<X>::head_of(whole)), row_count_(RowsOf<X>::count(whole)) {
  ByteWriter writer;
  writer.reserve(row_count_ * RowsOf<X>::size(whole));
  if constexpr (requires { RowsOf<X>::in_order(whole); }) {
    RowsOf<X>::encode(RowsOf<X>::in_order(whole), 0, row_count_, writer);
  } else {
    RowsOf<X>::encode(whole, 0, row_count_, writer);
  }
  if constexpr (HasTiles<X>) add_to_tiles(writer.bytes());
  rows_ = StoredBytes(writer.take());
}

template <HasRows X>
Result<X> StoredTable<X>::rows(std::uint64_t first, std::uint64_t count) const {
  SIGHTLINE_CHECK(first <= row_count_ && count <= row_count_ - first);
  X some = RowsOf<X>::part_of(head_, first, count);
  RowsOf<X>::resize(some, count);
  SIGHTLINE_TRY(read(first, count, some, 0));
  return some;
}

template <HasRows X>
Result<X> StoredTable<X>::whole() const {
  X all = head_;
  RowsOf<X>::resize(all, row_count_);
  SIGHTLINE_TRY(read(0, row_count_, all, 0));
  return all;
}

template <HasRows X>
Result<X> StoredTable<X>::over(const Eigen::AlignedBox2d& box_m) const {
  X near = RowsOf<X>::part_of(head_, 0, 0);
  if (box_m.isEmpty()) return near;
  const TileKey low = tile_key({box_m.min().x(), box_m.min().y(), 0.0}, head_.tile_m);
  const TileKey high = tile_key({box_m.max().x(), box_m.max().y(), 0.0}, head_.tile_m);
  auto tile = std::ranges::lower_bound(tiles_, low, {}, &RowTile::key);
  for (; tile != tiles_.end() && tile->key.x <= high.x; ++tile) {
    if (tile->key.y < low.y || high.y < tile->key.y) continue;
    const std::size_t before = RowsOf<X>::count(near);
    RowsOf<X>::resize(near, before + tile->count);
    SIGHTLINE_TRY(read(tile->first, tile->count, near, before));
  }
  return near;
}

template <HasRows X>
Result<void> StoredTable<X>::read(std::uint64_t first, std::uint64_t count, X& into,
                                  std::size_t at) const {
  const std::size_t size = RowsOf<X>::size(head_);
  return stored_table::visit_stretches(
      count, [&](std::uint64_t done, std::uint64_t here) -> Result<void> {
        SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                         rows_.read((first + done) * size, here * size));
        ByteReader reader(bytes);
        RowsOf<X>::decode(reader, into, at + done, here);
        SIGHTLINE_CHECK(reader.at_end());
        return {};
      });
}

template <HasRows X>
Result<StoredTable<X>> StoredTable<X>::open(const StoredBytes& payload) {
  SIGHTLINE_ASSIGN(StoredTable opened, open_front(payload));
  if (payload_size(opened) != payload.size()) return undecodable<StoredTable<X>>();
  return opened;
}

template <HasRows X>
Result<StoredTable<X>> StoredTable<X>::open_front(const StoredBytes& payload) {
  StoredTable opened;
  const auto decode = [&](ByteReader& reader) {
    opened.head_ = X();
    RowsOf<X>::decode_head(reader, opened.head_);
    reader.get(opened.row_count_);
  };
  SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> begin, decode_front(payload, decode));
  if (!begin) return undecodable<StoredTable<X>>();
  const std::size_t size = RowsOf<X>::size(opened.head_);
  const std::uint64_t rest = payload.size() - *begin;
  const bool is_full = HasTiles<X> || opened.row_count_ == RowsOf<X>::count(opened.head_);
  if (!is_full || size == 0 || rest / size < opened.row_count_) {
    return undecodable<StoredTable<X>>();
  }
  opened.rows_ = payload.part(*begin, opened.row_count_ * size);
  if constexpr (HasTiles<X>) SIGHTLINE_TRY(opened.find_tiles());
  return opened;
}

template <HasRows X>
Result<void> StoredTable<X>::find_tiles() {
  // The size of tiles is known from here on.
  SIGHTLINE_TRY(validate(head_));
  const std::size_t size = RowsOf<X>::size(head_);
  return stored_table::visit_stretches(
      row_count_, [&](std::uint64_t first, std::uint64_t count) -> Result<void> {
        SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                         rows_.read(first * size, count * size));
        add_to_tiles(bytes);
        return {};
      });
}

template <HasRows X>
void StoredTable<X>::add_to_tiles(std::span<const std::byte> rows) {
  const std::size_t size = RowsOf<X>::size(head_);
  for (; !rows.empty(); rows = rows.subspan(size)) {
    const std::span<const std::byte> row = rows.first(size);
    const TileKey key = RowsOf<X>::tile(head_, row);
    if (tiles_.empty() || tiles_.back().key != key) {
      const std::uint64_t first = tiles_.empty() ? 0 : tiles_.back().first + tiles_.back().count;
      tiles_.push_back({key, first, 0});
    }
    ++tiles_.back().count;
    reach_m_ = std::max(reach_m_, RowsOf<X>::reach_m(row));
  }
}

}  // namespace sightline
