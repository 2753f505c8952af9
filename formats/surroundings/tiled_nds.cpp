#include "formats/surroundings/tiled_nds.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "formats/base/check.h"

// Bytes are those of encode(NdtMap): a head of fixed size, whose last number counts the NDs, and
// the NDs, each of fixed size. That function writes and reads them here too, stretch by stretch.

namespace sightline {
namespace {

// NDs that are looked at together where all are.
constexpr std::uint64_t kStretch = 8192;

NdtMap without_nds(const NdtMap& map) {
  return {
      map.frame,      map.cell_m, map.tile_m, {}, map.sparse_cell_count, map.degenerate_cell_count,
      map.point_count};
}

// What precedes `count` NDs.
std::vector<std::byte> head_bytes(const NdtMap& head, std::uint64_t count) {
  ByteWriter writer;
  encode(head, writer);
  std::vector<std::byte> bytes = writer.take();
  const auto number = std::as_bytes(std::span(&count, 1));
  std::ranges::copy(number, bytes.end() - static_cast<std::ptrdiff_t>(number.size()));
  return bytes;
}

std::size_t head_size() {
  static const std::size_t kSize = head_bytes({}, 0).size();
  return kSize;
}

Error malformed(std::uint64_t byte) {
  return {ErrorCode::kBadLayer, "the payload of an ndt-map cannot be decoded", "",
          "payload byte " + std::to_string(byte)};
}

Error in_tile(Error error, const TileKey& tile) {
  error.place = "tile " + std::to_string(tile.x) + ", " + std::to_string(tile.y) +
                (error.place.empty() ? "" : ", ") + error.place;
  return error;
}

}  // namespace

std::vector<std::byte> encoded_nds(std::span<const Nd> nds) {
  NdtMap part;
  part.nds.assign(nds.begin(), nds.end());
  ByteWriter writer;
  writer.reserve(head_size() + nds.size() * kEncodedNd);
  encode(part, writer);
  std::vector<std::byte> bytes = writer.take();
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(head_size()));
  SIGHTLINE_CHECK(bytes.size() == nds.size() * kEncodedNd);
  return bytes;
}

void append_nds(std::span<const std::byte> bytes, NdtMap& map) {
  SIGHTLINE_CHECK(bytes.size() % kEncodedNd == 0);
  std::vector<std::byte> with_head = head_bytes(without_nds(map), bytes.size() / kEncodedNd);
  with_head.insert(with_head.end(), bytes.begin(), bytes.end());
  ByteReader reader(with_head);
  NdtMap part;
  decode(reader, part);
  SIGHTLINE_CHECK(reader.at_end());
  map.nds.insert(map.nds.end(), part.nds.begin(), part.nds.end());
}

TiledNds::TiledNds(const NdtMap& whole) {
  constexpr std::size_t kAllInMemory = std::numeric_limits<std::size_t>::max();
  TiledNdsWriter writer(kAllInMemory);
  for (std::size_t first = 0; first < whole.nds.size();) {
    const TileKey key = tile_of(whole.nds[first].key, whole.cell_m, whole.tile_m);
    std::size_t end = first + 1;
    while (end < whole.nds.size() &&
           tile_of(whole.nds[end].key, whole.cell_m, whole.tile_m) == key) {
      ++end;
    }
    const Result<void> added = writer.add(key, std::span(whole.nds).subspan(first, end - first));
    SIGHTLINE_CHECK(added.has_value());
    first = end;
  }
  *this = writer.take(whole);
}

std::uint64_t TiledNds::nd_count() const { return nds_.size() / kEncodedNd; }

Result<void> TiledNds::append(std::uint64_t first, std::uint64_t count, NdtMap& map) const {
  for (std::uint64_t i = 0; i < count; i += kStretch) {
    SIGHTLINE_ASSIGN(
        const std::vector<std::byte> bytes,
        nds_.read((first + i) * kEncodedNd, std::min(kStretch, count - i) * kEncodedNd));
    append_nds(bytes, map);
  }
  return {};
}

void TiledNds::add_to_tiles(const TileKey& key, std::uint64_t count) {
  if (tiles_.empty() || tiles_.back().key != key) {
    const std::uint64_t first = tiles_.empty() ? 0 : tiles_.back().first + tiles_.back().count;
    tiles_.push_back({key, first, 0});
  }
  tiles_.back().count += count;
}

Result<NdtMap> TiledNds::tile(const NdTile& tile) const {
  NdtMap map{head_.frame, head_.cell_m, head_.tile_m, {}, 0, 0, 0};
  SIGHTLINE_TRY(append(tile.first, tile.count, map));
  return map;
}

Result<NdtMap> TiledNds::over(const Eigen::AlignedBox2d& box_m) const {
  NdtMap near{head_.frame, head_.cell_m, head_.tile_m, {}, 0, 0, 0};
  if (box_m.isEmpty()) return near;
  const TileKey low = tile_key({box_m.min().x(), box_m.min().y(), 0.0}, head_.tile_m);
  const TileKey high = tile_key({box_m.max().x(), box_m.max().y(), 0.0}, head_.tile_m);
  auto tile = std::ranges::lower_bound(tiles_, low, {}, &NdTile::key);
  for (; tile != tiles_.end() && tile->key.x <= high.x; ++tile) {
    const bool is_over = low.y <= tile->key.y && tile->key.y <= high.y;
    if (is_over) SIGHTLINE_TRY(append(tile->first, tile->count, near));
  }
  return near;
}

Result<NdtMap> TiledNds::whole() const {
  NdtMap map = head_;
  map.nds.reserve(nd_count());
  SIGHTLINE_TRY(append(0, nd_count(), map));
  return map;
}

Result<void> TiledNdsWriter::add(const TileKey& key, std::span<const Nd> nds) {
  if (nds.empty()) return {};
  made_.add_to_tiles(key, nds.size());
  return bytes_.append(encoded_nds(nds));
}

TiledNds TiledNdsWriter::take(const NdtMap& head) {
  made_.head_ = without_nds(head);
  made_.nds_ = bytes_.take();
  return std::move(made_);
}

Result<void> validate(const TiledNds& nds) {
  SIGHTLINE_TRY(validate(nds.head()));
  for (std::size_t i = 0; i < nds.tiles().size(); ++i) {
    const NdTile& tile = nds.tiles()[i];
    if (i > 0 && !(nds.tiles()[i - 1].key < tile.key)) {
      return in_tile({ErrorCode::kInvalidArtifact, "tiles must ascend"}, tile.key);
    }
    SIGHTLINE_ASSIGN(const NdtMap of_tile, nds.tile(tile));
    const Result<void> checked = validate(of_tile);
    if (!checked) return in_tile(checked.error(), tile.key);
    for (const Nd& nd : of_tile.nds) {
      if (tile_of(nd.key, nds.cell_m(), nds.tile_m()) == tile.key) continue;
      return in_tile({ErrorCode::kInvalidArtifact, "an ND lies in another tile"}, tile.key);
    }
  }
  return {};
}

Table dump(const TiledNds& nds) {
  const Result<NdtMap> whole = nds.whole();
  SIGHTLINE_CHECK(whole.has_value());
  return dump(*whole);
}

std::uint64_t payload_size(const TiledNds& nds) { return head_size() + nds.nds_.size(); }

Result<void> visit_payload(const TiledNds& nds, const ByteSink& sink) {
  SIGHTLINE_TRY(sink(head_bytes(nds.head_, nds.nd_count())));
  return nds.nds_.visit(sink);
}

Result<void> open_payload(const StoredBytes& payload, TiledNds& nds) {
  if (payload.size() < head_size()) return malformed(payload.size());
  SIGHTLINE_ASSIGN(std::vector<std::byte> head, payload.read(0, head_size()));
  std::uint64_t count = 0;
  const auto number = std::as_writable_bytes(std::span(&count, 1));
  const auto in_head = std::span(head).last(number.size());
  std::ranges::copy(in_head, number.begin());
  std::ranges::fill(in_head, std::byte{0});
  ByteReader reader(head);
  TiledNds opened;
  decode(reader, opened.head_);
  SIGHTLINE_CHECK(reader.at_end());
  const std::uint64_t size = payload.size() - head_size();
  if (size % kEncodedNd != 0 || count != size / kEncodedNd) return malformed(head_size());
  // What tiles are is known from here on.
  SIGHTLINE_TRY(validate(opened.head_));
  opened.nds_ = payload.part(head_size(), size);
  for (std::uint64_t first = 0; first < count; first += kStretch) {
    const std::uint64_t here = std::min(kStretch, count - first);
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                     opened.nds_.read(first * kEncodedNd, here * kEncodedNd));
    for (std::uint64_t i = 0; i < here; ++i) {
      const std::span<const std::byte> nd(bytes.data() + i * kEncodedNd, kEncodedNd);
      ByteReader of_nd(nd);
      CellKey key;
      of_nd.get(key.x);
      of_nd.get(key.y);
      of_nd.get(key.z);
      opened.add_to_tiles(tile_of(key, opened.head_.cell_m, opened.head_.tile_m), 1);
    }
  }
  SIGHTLINE_TRY(validate(opened));
  nds = std::move(opened);
  return {};
}

}  // namespace sightline
