#include "formats/map/drives_section.h"

#include <string>

namespace sightline {

std::vector<std::byte> encode_drives(const TileDrives& tiles) {
  ByteWriter writer;
  encode(tiles, writer);
  return writer.take();
}

Result<TileDrives> decode_drives(std::span<const std::byte> raw, std::uint32_t version,
                                 std::uint64_t row_count) {
  TileDrives tiles;
  ByteReader reader(raw);
  version == 1 ? decode_version_1(reader, tiles) : decode(reader, tiles);
  if (!reader.at_end() || tiles.rows.size() != row_count) {
    return Error{
        ErrorCode::kBadLayer,
        concat("found ", raw.size(), " bytes of the drives of tiles, in ", row_count, " rows")};
  }
  SIGHTLINE_TRY(validate(tiles));
  return tiles;
}

std::vector<std::byte> encode_recordings(const RecordingCards& recordings) {
  ByteWriter writer;
  encode(recordings, writer);
  return writer.take();
}

Result<RecordingCards> decode_recordings(std::span<const std::byte> raw, std::uint64_t row_count) {
  RecordingCards recordings;
  ByteReader reader(raw);
  decode(reader, recordings);
  if (!reader.at_end() || recordings.cards.size() != row_count) {
    return Error{ErrorCode::kBadLayer,
                 concat("found ", raw.size(), " bytes of recordings, in ", row_count, " rows")};
  }
  SIGHTLINE_TRY(validate(recordings));
  return recordings;
}

}  // namespace sightline
