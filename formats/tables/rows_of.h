#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/artifact.h"
#include "formats/grid/cell_key.h"
#include "formats/record/codec.h"

// How a struct of rows is encoded: a head, the number of rows, and the rows, each of the same size.
//
// A struct X describes its rows beside its own declaration:
//
//   template <> struct RowsOf<X> {
//     static std::size_t size(const X& head);    // of an encoded row; 0: there are no such rows
//     static std::size_t count(const X&);        // rows of a whole X
//     static X head_of(const X&);                // all but the rows
//     static X part_of(const X& head, std::size_t first, std::size_t count);  // head of some rows
//     static void resize(X& head, std::size_t count);  // room for them
//     static void encode_head(const X&, ByteWriter&);
//     static void decode_head(ByteReader&, X&);
//     static void encode(const X&, std::size_t first, std::size_t count, ByteWriter&);
//     static void decode(ByteReader&, X&, std::size_t first, std::size_t count);
//   };
//
// Rows of an X that is a piece of the plane lie tile after tile. It also has
//
//     static TileKey tile(const X& head, std::span<const std::byte> row);
//     static double reach_m(std::span<const std::byte> row);  // from its place, along each axis
//
// and, where rows of a whole X may have another order than that of its table,
//
//     static X in_order(const X& whole);
//
// Rows of any other X are sites: its head counts them.

namespace sightline {

template <class X>
struct RowsOf;

// What RowsOf<X> has in common for rows that an X with fields holds in a vector: the head is every
// other field.
template <class X, class Row, std::vector<Row> X::*kRows>
struct RowsInVector {
  static std::size_t count(const X& whole) { return (whole.*kRows).size(); }
  static void resize(X& head, std::size_t count) { (head.*kRows).resize(count); }
  static void encode_head(const X& whole, ByteWriter& writer) {
    visit_head(whole, FieldWriter(writer));
  }
  static void decode_head(ByteReader& reader, X& head) { visit_head(head, FieldReader(reader)); }
  static void encode(const X& whole, std::size_t first, std::size_t count, ByteWriter& writer) {
    for (const Row& row : std::span(whole.*kRows).subspan(first, count)) {
      FieldWriter(writer).put(row);
    }
  }
  static void decode(ByteReader& reader, X& whole, std::size_t first, std::size_t count) {
    for (Row& row : std::span(whole.*kRows).subspan(first, count)) FieldReader(reader).get(row);
  }

 private:
  template <class AnyX, class Codec>
  static void visit_head(AnyX& whole, Codec codec) {
    const auto visit = [&](std::string_view name, auto& field) {
      if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(field)>, std::vector<Row>>) {
        codec(name, field);
      }
    };
    fields(visit, whole);
  }
};

template <class X>
concept HasRows = requires(const X& head) {
  { RowsOf<X>::size(head) } -> std::same_as<std::size_t>;
};
template <class X>
concept HasTiles = HasRows<X> && requires(const X& head, std::span<const std::byte> row) {
  { RowsOf<X>::tile(head, row) } -> std::same_as<TileKey>;
};

// Rows that are taken through memory at once.
inline constexpr std::size_t kRowsAtOnce = 256;

namespace stored_table {

// What precedes `count` rows.
template <HasRows X>
std::vector<std::byte> head_bytes(const X& head, std::uint64_t count) {
  ByteWriter writer;
  RowsOf<X>::encode_head(head, writer);
  writer.put(count);
  return writer.take();
}

// Calls use(first, count) for rows that are taken at once, until it returns an error.
template <class Use>
Result<void> visit_stretches(std::uint64_t row_count, const Use& use) {
  for (std::uint64_t first = 0; first < row_count; first += kRowsAtOnce) {
    SIGHTLINE_TRY(use(first, std::min<std::uint64_t>(kRowsAtOnce, row_count - first)));
  }
  return {};
}

}  // namespace stored_table

// The bytes of a whole X are those of its table.
template <HasRows X>
Result<void> visit_whole(const X& whole, const ByteSink& sink) {
  const std::size_t row_count = RowsOf<X>::count(whole);
  SIGHTLINE_TRY(sink(stored_table::head_bytes(whole, row_count)));
  return stored_table::visit_stretches(row_count, [&](std::size_t first, std::size_t count) {
    ByteWriter rows;
    RowsOf<X>::encode(whole, first, count, rows);
    return sink(rows.bytes());
  });
}

template <HasRows X>
void encode_whole(const X& whole, ByteWriter& writer) {
  encode_by_visiting([&](const ByteSink& sink) { return visit_whole(whole, sink); }, writer);
}

template <HasRows X>
void decode_whole(ByteReader& reader, X& whole) {
  X found;
  RowsOf<X>::decode_head(reader, found);
  const std::size_t size = reader.ok() ? RowsOf<X>::size(found) : 0;
  const std::size_t count = reader.get_count(std::max<std::size_t>(1, size));
  const bool is_full = HasTiles<X> || count == RowsOf<X>::count(found);
  if (!is_full || (size == 0 && count > 0)) reader.fail();
  if (!reader.ok()) return;
  RowsOf<X>::resize(found, count);
  RowsOf<X>::decode(reader, found, 0, count);
  whole = std::move(found);
}

}  // namespace sightline
