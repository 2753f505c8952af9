#include "formats/foreign/ros/files/mcap_record.h"

#include <array>

#include "formats/base/bytes.h"

namespace sightline {
namespace {

std::string take_text(ByteReader& reader, std::span<const std::byte> data) {
  const auto size = reader.get<std::uint32_t>();
  if (size > reader.remaining()) reader.fail();
  if (!reader.ok()) return {};
  const auto* begin = reinterpret_cast<const char*>(data.data()) + reader.offset();
  for (std::uint32_t i = 0; i < size; ++i) reader.get<char>();
  return {begin, size};
}

template <class T>
std::optional<T> if_whole(const ByteReader& reader, T value) {
  return reader.ok() ? std::optional<T>(std::move(value)) : std::nullopt;
}

}  // namespace

Result<McapOutline> read_mcap_outline(const RandomAccessFile& file, std::uint64_t offset) {
  const auto cut = [&](const std::string& what) {
    return Error{ErrorCode::kTruncatedScan,
                 "the file ends within " + what + "; `mcap recover` saves what there is",
                 file.path().string(), "byte " + std::to_string(offset)};
  };
  if (offset > file.size() || file.size() - offset < kMcapPrefixSize) return cut("a record");
  std::array<std::byte, kMcapPrefixSize> prefix{};
  SIGHTLINE_TRY(file.read(offset, prefix));
  ByteReader reader(prefix);
  McapOutline outline;
  outline.offset = offset;
  outline.op = reader.get<McapOp>();
  outline.data_offset = offset + kMcapPrefixSize;
  outline.data_size = reader.get<std::uint64_t>();
  if (outline.data_size <= file.size() - outline.data_offset) return outline;
  return cut("a record of " + std::to_string(outline.data_size) + " bytes");
}

std::optional<McapRecord> take_mcap_record(std::span<const std::byte> bytes, std::size_t& offset) {
  ByteReader reader(bytes.subspan(offset));
  McapRecord record;
  record.op = reader.get<McapOp>();
  const auto size = reader.get<std::uint64_t>();
  if (!reader.ok() || size > reader.remaining()) return std::nullopt;
  record.data = bytes.subspan(offset + kMcapPrefixSize, static_cast<std::size_t>(size));
  offset += kMcapPrefixSize + record.data.size();
  return record;
}

std::optional<McapSchema> mcap_schema(std::span<const std::byte> data) {
  ByteReader reader(data);
  McapSchema schema;
  reader.get(schema.id);
  schema.name = take_text(reader, data);
  take_text(reader, data);  // encoding of the definition
  take_text(reader, data);  // the definition
  if (schema.id == 0) return std::nullopt;
  return if_whole(reader, std::move(schema));
}

std::optional<McapChannel> mcap_channel(std::span<const std::byte> data) {
  ByteReader reader(data);
  McapChannel channel;
  reader.get(channel.id);
  reader.get(channel.schema_id);
  channel.topic = take_text(reader, data);
  channel.encoding = take_text(reader, data);
  return if_whole(reader, std::move(channel));
}

std::optional<McapMessage> mcap_message(std::span<const std::byte> data) {
  ByteReader reader(data);
  McapMessage message;
  reader.get(message.channel_id);
  reader.get<std::uint32_t>();  // its number
  reader.get(message.log_time_ns);
  reader.get<std::uint64_t>();  // time of publishing
  return if_whole(reader, message);
}

std::optional<McapChunkHeader> mcap_chunk_header(std::span<const std::byte> first_bytes) {
  ByteReader reader(first_bytes);
  McapChunkHeader header;
  reader.get<std::uint64_t>();  // times of the first and the last message
  reader.get<std::uint64_t>();
  reader.get(header.unpacked_size);
  reader.get(header.crc);
  header.compression = take_text(reader, first_bytes);
  reader.get(header.size);
  header.header_size = reader.offset();
  return if_whole(reader, std::move(header));
}

std::optional<McapMessageIndex> mcap_message_index(std::span<const std::byte> first_bytes,
                                                   std::uint64_t data_size) {
  constexpr std::uint32_t kEntrySize = 16;  // a time and a place
  ByteReader reader(first_bytes);
  McapMessageIndex index;
  reader.get(index.channel_id);
  const auto size = reader.get<std::uint32_t>();
  if (!reader.ok() || size % kEntrySize != 0 || size > data_size - reader.offset()) {
    return std::nullopt;
  }
  index.message_count = size / kEntrySize;
  return index;
}

}  // namespace sightline
