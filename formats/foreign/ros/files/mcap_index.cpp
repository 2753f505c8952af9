#include "formats/foreign/ros/files/mcap_index.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "formats/base/bytes.h"

// A file is a magic number, a header, the data (schemas, channels, chunks of messages, or messages
// as they are; behind a chunk the places of its messages by channel), the end of the data, a
// summary that repeats schemas and channels and lists where chunks lie, a footer, and the magic
// number again. The records are walked through in turn: that costs one read for each chunk, needs
// no summary, and a place that is not believed cannot be wrong.

namespace sightline {
namespace {

using namespace std::string_view_literals;
constexpr std::string_view kMagic = "\x89MCAP0\r\n"sv;
constexpr std::uint64_t kMostDescription = 1U << 24U;  // a schema with all its definitions

// A record whose data were not read.
struct McapOutline {
  std::uint64_t offset = 0;
  McapOp op{};  // also a kind that is not named above
  std::uint64_t data_offset = 0;
  std::uint64_t data_size = 0;
  [[nodiscard]] std::uint64_t end() const { return data_offset + data_size; }
};

struct McapChunkHeader {
  static constexpr std::size_t kMostSize = 64;  // with the longest name of a compression
  std::uint64_t unpacked_size = 0;
  std::uint32_t crc = 0;  // of the unpacked records; 0: none
  std::string compression;
  std::uint64_t size = 0;  // of the records as they lie
  std::size_t header_size = 0;
};
struct McapMessageIndex {
  std::uint16_t channel_id = 0;
  std::uint32_t message_count = 0;
};

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

// Errors: cannot-read, truncated-scan (the file ends within it).
Result<McapOutline> read_mcap_outline(const RandomAccessFile& file, std::uint64_t offset) {
  const auto cut = [&](const std::string& what) {
    return file.error_at(offset,
                         "the file ends within " + what + "; `mcap recover` saves what there is",
                         ErrorCode::kTruncatedScan);
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

// Each gives nothing for data that are cut or contradict themselves. Further fields at the end are
// those of later versions.
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

// From the first 6 bytes of a record of `data_size`.
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

class IndexReader {
 public:
  explicit IndexReader(const RandomAccessFile& file) : file_(file) {}
  Result<McapIndex> read();

 private:
  Result<void> check_magic(std::uint64_t offset) const;
  Result<void> add(const McapOutline& record);
  Result<void> add_description(const McapOutline& record);
  Result<void> add_message(const McapOutline& record);
  Result<void> add_chunk(const McapOutline& record);
  Result<void> add_counts(const McapOutline& record);
  Result<std::vector<std::byte>> first_bytes(const McapOutline& record, std::uint64_t most) const;
  [[nodiscard]] Error damaged(const McapOutline& record, std::string message) const {
    return file_.error_at(record.offset, std::move(message));
  }

  const RandomAccessFile& file_;
  McapIndex index_;
  bool is_behind_data_ = false;
};

Result<void> IndexReader::check_magic(std::uint64_t offset) const {
  std::string found(std::min<std::uint64_t>(file_.size() - offset, kMagic.size()), '\0');
  SIGHTLINE_TRY(file_.read(offset, std::as_writable_bytes(std::span(found))));
  if (found == kMagic) return {};
  if (kMagic.starts_with(found)) {
    return file_.error_at(offset, "the file ends within its magic number",
                          ErrorCode::kTruncatedScan);
  }
  if (offset > 0) return file_.error_at(offset, "expected the magic number of MCAP at the end");
  return file_.error_at(0, "expected MCAP of version 0", ErrorCode::kUnsupportedFormat);
}

Result<std::vector<std::byte>> IndexReader::first_bytes(const McapOutline& record,
                                                        std::uint64_t most) const {
  std::vector<std::byte> bytes(static_cast<std::size_t>(std::min(record.data_size, most)));
  SIGHTLINE_TRY(file_.read(record.data_offset, bytes));
  return bytes;
}

Result<void> IndexReader::add_description(const McapOutline& record) {
  if (record.data_size > kMostDescription) {
    return damaged(record, "found a schema or channel of " + std::to_string(record.data_size) +
                               " bytes, expected at most " + std::to_string(kMostDescription));
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data, first_bytes(record, kMostDescription));
  if (index_.add({record.op, data})) return {};
  return damaged(record, "found a schema or channel that is cut or contradicts one of its number");
}

Result<void> IndexReader::add_message(const McapOutline& record) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data,
                   first_bytes(record, McapMessage::kHeaderSize));
  const std::optional<McapMessage> message = mcap_message(data);
  if (!message) return damaged(record, "found a message shorter than its header");
  if (!index_.channels.contains(message->channel_id)) {
    return damaged(record, "found a message before its channel");
  }
  index_.messages.push_back(
      {*message, record.data_offset + data.size(), record.data_size - data.size()});
  return {};
}

Result<void> IndexReader::add_chunk(const McapOutline& record) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data,
                   first_bytes(record, McapChunkHeader::kMostSize));
  const std::optional<McapChunkHeader> header = mcap_chunk_header(data);
  if (!header || header->size > record.data_size - header->header_size) {
    return damaged(record, "found a chunk whose header is cut or promises more than its record");
  }
  const std::optional<BagCompression> compression = mcap_compression_named(header->compression);
  if (!compression) {
    return file_.error_at(record.offset,
                          "found a chunk with a compression other than none, lz4 and zstd",
                          ErrorCode::kUnsupportedFormat);
  }
  const bool is_packed = *compression != BagCompression::kNone;
  if (is_packed
          ? header->unpacked_size > most_unpacked(header->size)
          : header->unpacked_size != header->size || header->size > most_unpacked(header->size)) {
    return damaged(record, "found a chunk of " + std::to_string(header->unpacked_size) +
                               " bytes in " + std::to_string(header->size) + " bytes");
  }
  index_.chunks.push_back({record.offset,
                           record.data_offset + header->header_size,
                           header->size,
                           header->unpacked_size,
                           header->crc,
                           *compression,
                           false,
                           {}});
  return {};
}

Result<void> IndexReader::add_counts(const McapOutline& record) {
  constexpr std::uint64_t kFirst = 6;
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data, first_bytes(record, kFirst));
  const std::optional<McapMessageIndex> found = mcap_message_index(data, record.data_size);
  if (!found || index_.chunks.empty()) {
    return damaged(record, "expected the places of a chunk's messages behind it");
  }
  McapChunk& chunk = index_.chunks.back();
  chunk.is_indexed = true;
  const bool is_repeated = chunk.message_counts.contains(found->channel_id);
  if (is_repeated) return damaged(record, "found the places of one channel's messages twice");
  if (found->message_count > 0) chunk.message_counts[found->channel_id] = found->message_count;
  return {};
}

Result<void> IndexReader::add(const McapOutline& record) {
  switch (record.op) {
    case McapOp::kSchema:
    case McapOp::kChannel:
      return add_description(record);
    case McapOp::kMessage:
    case McapOp::kChunk:
    case McapOp::kMessageIndex:
      if (is_behind_data_) return damaged(record, "found messages behind the end of the data");
      if (record.op == McapOp::kMessage) return add_message(record);
      return record.op == McapOp::kChunk ? add_chunk(record) : add_counts(record);
    case McapOp::kStatistics: {
      SIGHTLINE_ASSIGN(const std::vector<std::byte> data,
                       first_bytes(record, sizeof(std::uint64_t)));
      index_.said_messages = ByteReader(data).get<std::uint64_t>();
      return {};
    }
    case McapOp::kDataEnd:
      is_behind_data_ = true;
      return {};
    default:
      return {};  // what later versions add, attachments, where chunks lie
  }
}

Result<McapIndex> IndexReader::read() {
  SIGHTLINE_TRY(check_magic(0));
  for (std::uint64_t offset = kMagic.size(); offset < file_.size();) {
    SIGHTLINE_ASSIGN(const McapOutline record, read_mcap_outline(file_, offset));
    const bool is_first = offset == kMagic.size();
    if (is_first != (record.op == McapOp::kHeader)) {
      return damaged(record, is_first ? "expected the header of an MCAP file"
                                      : "found a second header; two files may have been joined");
    }
    offset = record.end();
    if (record.op != McapOp::kFooter) {
      SIGHTLINE_TRY(add(record));
      continue;
    }
    SIGHTLINE_TRY(check_magic(offset));
    if (offset + kMagic.size() != file_.size()) {
      return file_.error_at(offset + kMagic.size(), "found bytes behind the end of the file");
    }
    index_.is_closed = true;
    break;
  }
  return std::move(index_);
}

}  // namespace

bool McapIndex::add(const McapRecord& record) {
  if (record.op == McapOp::kSchema) {
    const std::optional<McapSchema> schema = mcap_schema(record.data);
    return schema && schemas.emplace(schema->id, *schema).first->second == *schema;
  }
  const std::optional<McapChannel> channel = mcap_channel(record.data);
  return channel && channels.emplace(channel->id, *channel).first->second == *channel;
}

Result<McapIndex> read_mcap_index(const RandomAccessFile& file) { return IndexReader(file).read(); }

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

std::optional<McapMessage> mcap_message(std::span<const std::byte> data) {
  ByteReader reader(data);
  McapMessage message;
  reader.get(message.channel_id);
  reader.get<std::uint32_t>();  // its number
  reader.get(message.log_time_ns);
  reader.get<std::uint64_t>();  // time of publishing
  return if_whole(reader, message);
}

}  // namespace sightline
