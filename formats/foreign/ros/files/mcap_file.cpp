#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/files/regular_file.h"
#include "formats/base/result.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/bag_chunks.h"
#include "formats/foreign/ros/files/open_message_log.h"

namespace sightline {
namespace {

// The records of an MCAP file (mcap.dev/spec): a kind in one byte, the length of what follows in
// 64 bits, and fields one after the other, little-endian, strings behind a 32-bit length.

enum class McapOp : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kStatistics = 11,
  kDataEnd = 15
};

inline constexpr std::size_t kMcapPrefixSize = 9;  // of a record: kind and length

// A record in memory.
struct McapRecord {
  McapOp op{};
  std::span<const std::byte> data;
};
struct McapSchema {
  std::uint16_t id = 0;
  std::string name;  // "sensor_msgs/msg/PointCloud2"
  auto operator<=>(const McapSchema&) const = default;
};
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  // 0: none
  std::string topic;
  std::string encoding;  // "cdr", "ros1"
  auto operator<=>(const McapChannel&) const = default;
};
struct McapMessage {
  static constexpr std::size_t kHeaderSize = 22;
  std::uint16_t channel_id = 0;
  std::int64_t log_time_ns = 0;
};

// A chunk of records, as it lies in the file.
struct McapChunk {
  std::uint64_t offset = 0;       // of its record, bytes of the file
  std::uint64_t data_offset = 0;  // of what may be packed
  std::uint64_t data_size = 0;
  std::uint64_t unpacked_size = 0;
  std::uint32_t crc = 0;
  BagCompression compression = BagCompression::kNone;
  bool is_indexed = false;                                // the counts were said behind it
  std::map<std::uint16_t, std::uint64_t> message_counts;  // by channel
};

// A message outside of chunks.
struct McapLoneMessage {
  McapMessage message;
  std::uint64_t data_offset = 0;
  std::uint64_t data_size = 0;
};

struct McapIndex {
  std::map<std::uint16_t, McapSchema> schemas;
  std::map<std::uint16_t, McapChannel> channels;
  std::vector<McapChunk> chunks;  // ascending, none within another
  std::vector<McapLoneMessage> messages;
  std::optional<std::uint64_t> said_messages;  // how many the summary counts
  bool is_closed = false;  // the file has the end that its writer gives it at last

  // Takes a schema or a channel; false where it contradicts one of the same number, or is none.
  bool add(const McapRecord& record);
};

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
    return file.error_at(
        offset, concat("the file ends within ", what, "; `mcap recover` recovers the rest"),
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
  return cut(concat("a record of ", outline.data_size, " bytes"));
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

// Nothing for data that are cut.
std::optional<McapMessage> mcap_message(std::span<const std::byte> data) {
  ByteReader reader(data);
  McapMessage message;
  reader.get(message.channel_id);
  reader.get<std::uint32_t>();  // its number
  reader.get(message.log_time_ns);
  reader.get<std::uint64_t>();  // time of publishing
  return if_whole(reader, message);
}

// Walks through the records of the file, but for what lies in chunks; what the summary at its end
// says of places is not needed. A file that was not closed may end behind any record. Errors:
// cannot-read, malformed-header, truncated-scan, unsupported-format; all with the byte.
class IndexReader {
 public:
  explicit IndexReader(const RandomAccessFile& file) : file_(file) {}

  Result<McapIndex> read() {
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
        return file_.error_at(offset + kMagic.size(), "found bytes after the end of the file");
      }
      index_.is_closed = true;
      break;
    }
    return std::move(index_);
  }

 private:
  Result<void> check_magic(std::uint64_t offset) const {
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

  Result<void> add(const McapOutline& record) {
    switch (record.op) {
      case McapOp::kSchema:
      case McapOp::kChannel:
        return add_description(record);
      case McapOp::kMessage:
      case McapOp::kChunk:
      case McapOp::kMessageIndex:
        if (is_behind_data_) return damaged(record, "found messages after the end of the data");
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

  Result<void> add_description(const McapOutline& record) {
    if (record.data_size > kMostDescription) {
      return damaged(record, concat("found a schema or channel of ", record.data_size,
                                    " bytes, expected at most ", kMostDescription));
    }
    SIGHTLINE_ASSIGN(const std::vector<std::byte> data, first_bytes(record, kMostDescription));
    if (index_.add({record.op, data})) return {};
    return damaged(
        record, "found a schema or channel that is cut, or differs from one with the same number");
  }

  Result<void> add_message(const McapOutline& record) {
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

  Result<void> add_chunk(const McapOutline& record) {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> data,
                     first_bytes(record, McapChunkHeader::kMostSize));
    const std::optional<McapChunkHeader> header = mcap_chunk_header(data);
    if (!header || header->size > record.data_size - header->header_size) {
      return damaged(record, "found a chunk whose header is cut, or is larger than its record");
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
      return damaged(record, concat("found a chunk of ", header->unpacked_size, " bytes in ",
                                    header->size, " bytes"));
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

  Result<void> add_counts(const McapOutline& record) {
    constexpr std::uint64_t kFirst = 6;
    SIGHTLINE_ASSIGN(const std::vector<std::byte> data, first_bytes(record, kFirst));
    const std::optional<McapMessageIndex> found = mcap_message_index(data, record.data_size);
    if (!found || index_.chunks.empty()) {
      return damaged(record, "expected the index of a chunk's messages after it");
    }
    McapChunk& chunk = index_.chunks.back();
    chunk.is_indexed = true;
    const bool is_repeated = chunk.message_counts.contains(found->channel_id);
    if (is_repeated) return damaged(record, "found the index of one channel's messages twice");
    if (found->message_count > 0) chunk.message_counts[found->channel_id] = found->message_count;
    return {};
  }

  Result<std::vector<std::byte>> first_bytes(const McapOutline& record, std::uint64_t most) const {
    std::vector<std::byte> bytes(static_cast<std::size_t>(std::min(record.data_size, most)));
    SIGHTLINE_TRY(file_.read(record.data_offset, bytes));
    return bytes;
  }

  [[nodiscard]] Error damaged(const McapOutline& record, std::string message) const {
    return file_.error_at(record.offset, std::move(message));
  }

  const RandomAccessFile& file_;
  McapIndex index_;
  bool is_behind_data_ = false;
};

bool McapIndex::add(const McapRecord& record) {
  if (record.op == McapOp::kSchema) {
    const std::optional<McapSchema> schema = mcap_schema(record.data);
    return schema && schemas.emplace(schema->id, *schema).first->second == *schema;
  }
  const std::optional<McapChannel> channel = mcap_channel(record.data);
  return channel && channels.emplace(channel->id, *channel).first->second == *channel;
}

// The record at `offset` of bytes, and sets `offset` behind it; nothing where there is none that
// lies within the bytes.
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

using Bytes = std::vector<std::byte>;
constexpr std::size_t kNoChunk = SIZE_MAX;  // of a message outside of chunks

class McapFile : public MessageLog {
 public:
  explicit McapFile(RandomAccessFile file) : file_(std::move(file)) {}

  Result<void> build_index() {
    SIGHTLINE_ASSIGN(index_, IndexReader(file_).read());
    for (McapChunk& chunk : index_.chunks) {
      if (needs_unpacking(chunk)) SIGHTLINE_TRY(index_chunk(chunk));
    }
    SIGHTLINE_TRY(name_channels());
    warn();
    return {};
  }

  Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                const MessageBody& body) const override {
    for (std::size_t i = 0; i < index_.chunks.size(); ++i) {
      const McapChunk& chunk = index_.chunks[i];
      const bool is_wanted = std::ranges::any_of(
          chunk.message_counts, [&](const auto& entry) { return channels.contains(entry.first); });
      if (!is_wanted) continue;
      SIGHTLINE_ASSIGN(const Bytes bytes, unpack(chunk));
      Counts counts;
      const auto visit = [&](const McapMessage& message, std::span<const std::byte> data,
                             std::size_t offset) -> Result<void> {
        ++counts[message.channel_id];
        if (!channels.contains(message.channel_id)) return {};
        return body({message.channel_id, message.log_time_ns, {0, i, offset, data.size()}, data});
      };
      const auto pass_over = [](const McapRecord&, std::size_t) { return Result<void>(); };
      SIGHTLINE_TRY(walk(chunk, bytes, visit, pass_over));
      SIGHTLINE_TRY(check_counts(chunk, counts));
    }
    for (const McapLoneMessage& lone : index_.messages) {
      if (!channels.contains(lone.message.channel_id)) continue;
      const MessagePlace place{0, kNoChunk, lone.data_offset,
                               static_cast<std::size_t>(lone.data_size)};
      SIGHTLINE_ASSIGN(const Bytes bytes, read(place));
      SIGHTLINE_TRY(body({lone.message.channel_id, lone.message.log_time_ns, place, bytes}));
    }
    return {};
  }

  Result<Bytes> read(const MessagePlace& place) const override {
    if (place.chunk != kNoChunk &&
        index_.chunks.at(place.chunk).compression != BagCompression::kNone) {
      const McapChunk& chunk = index_.chunks[place.chunk];
      return recent_.read({place.chunk, static_cast<std::size_t>(chunk.unpacked_size),
                           static_cast<std::size_t>(place.offset), place.size},
                          [&] { return unpack(chunk); });
    }
    const std::uint64_t begin =
        place.chunk == kNoChunk ? 0 : index_.chunks[place.chunk].data_offset;
    Bytes message(place.size);
    SIGHTLINE_TRY(file_.read(begin + place.offset, message));
    return message;
  }

 private:
  using Counts = std::map<std::uint16_t, std::uint64_t>;

  [[nodiscard]] bool needs_unpacking(const McapChunk& chunk) const {
    return !chunk.is_indexed || std::ranges::any_of(chunk.message_counts, [&](const auto& entry) {
      return !index_.channels.contains(entry.first);
    });
  }

  [[nodiscard]] Result<Bytes> unpack(const McapChunk& chunk) const {
    Bytes bytes(static_cast<std::size_t>(chunk.data_size));
    SIGHTLINE_TRY(file_.read(chunk.data_offset, bytes));
    if (chunk.compression != BagCompression::kNone) {
      std::optional<Bytes> unpacked =
          unpack_chunk(chunk.compression, bytes, static_cast<std::size_t>(chunk.unpacked_size));
      if (!unpacked) {
        return file_.error_at(chunk.offset, concat("found a chunk that does not unpack to the ",
                                                   chunk.unpacked_size, " bytes of its header"));
      }
      bytes = *std::move(unpacked);
    }
    if (chunk.crc == 0) return bytes;
    const uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    if (crc == chunk.crc) return bytes;
    return file_.error_at(chunk.offset, "found a chunk that does not match its checksum");
  }

  // What stands behind the chunk would have said, and the schemas and channels in it.
  Result<void> index_chunk(McapChunk& chunk) {
    SIGHTLINE_ASSIGN(const Bytes bytes, unpack(chunk));
    Counts counts;
    const auto count = [&](const McapMessage& message, std::span<const std::byte>,
                           std::size_t offset) -> Result<void> {
      if (!index_.channels.contains(message.channel_id)) {
        return damaged(chunk, offset, "found a message before its channel");
      }
      ++counts[message.channel_id];
      return {};
    };
    const auto add = [&](const McapRecord& record, std::size_t offset) -> Result<void> {
      if (index_.add(record)) return {};
      return damaged(
          chunk, offset,
          "found a schema or channel that is cut, or differs from one with the same number");
    };
    SIGHTLINE_TRY(walk(chunk, bytes, count, add));
    if (chunk.is_indexed) SIGHTLINE_TRY(check_counts(chunk, counts));
    chunk.message_counts = std::move(counts);
    return {};
  }

  Result<void> name_channels() {
    for (const auto& [id, channel] : index_.channels) {
      const auto schema = index_.schemas.find(channel.schema_id);
      if (schema == index_.schemas.end() && channel.schema_id != 0) {
        return Error{ErrorCode::kMalformedHeader,
                     concat("found topic ", channel.topic, " of schema ", channel.schema_id,
                            ", which is not in the file"),
                     file_.path().string()};
      }
      const std::string type = schema == index_.schemas.end() ? "" : schema->second.name;
      channels_[id] = {channel.topic, ros1_type_name(type), encoding_named(channel.encoding), 0};
    }
    for (const McapChunk& chunk : index_.chunks) {
      for (const auto& [id, count] : chunk.message_counts) channels_[id].message_count += count;
    }
    for (const McapLoneMessage& lone : index_.messages) {
      ++channels_[lone.message.channel_id].message_count;
    }
    return {};
  }

  void warn() {
    const std::string name = file_.path().filename().string();
    if (!index_.is_closed) {
      warnings_.push_back(name +
                          ": the recording was not closed; its last messages may be missing");
    }
    std::uint64_t found = 0;
    for (const auto& [id, channel] : channels_) found += channel.message_count;
    if (index_.said_messages.value_or(found) == found) return;
    warnings_.push_back(concat(name, ": found ", found, " messages, expected ",
                               *index_.said_messages, "; a part of it may be damaged"));
  }

  Result<void> check_counts(const McapChunk& chunk, const Counts& found) const {
    if (found == chunk.message_counts) return {};
    return file_.error_at(chunk.offset, "the messages in this chunk differ from its index");
  }

  // Where in an unpacked chunk; a packed one has no bytes of the file for it.
  [[nodiscard]] Error damaged(const McapChunk& chunk, std::size_t offset,
                              const std::string& message) const {
    return file_.error_at(chunk.offset, concat(message, " at byte ", offset, " of this chunk's ",
                                               chunk.unpacked_size));
  }

  template <class OnMessage, class OnDescription>
  Result<void> walk(const McapChunk& chunk, std::span<const std::byte> bytes, OnMessage on_message,
                    OnDescription on_description) const;

  RandomAccessFile file_;
  McapIndex index_;
  mutable RecentChunks recent_;
};

// Calls on_message(message, its bytes, their offset) and on_description(record of a schema or
// channel, its offset), which return a Result<void>, for the records of a chunk.
template <class OnMessage, class OnDescription>
Result<void> McapFile::walk(const McapChunk& chunk, std::span<const std::byte> bytes,
                            OnMessage on_message, OnDescription on_description) const {
  for (std::size_t offset = 0; offset < bytes.size();) {
    const std::size_t begin = offset;
    const std::optional<McapRecord> record = take_mcap_record(bytes, offset);
    if (!record) return damaged(chunk, begin, "found no record");
    if (record->op == McapOp::kSchema || record->op == McapOp::kChannel) {
      SIGHTLINE_TRY(on_description(*record, begin));
    }
    if (record->op != McapOp::kMessage) continue;
    const std::optional<McapMessage> message = mcap_message(record->data);
    if (!message) return damaged(chunk, begin, "found a message shorter than its header");
    const std::span<const std::byte> data = record->data.subspan(McapMessage::kHeaderSize);
    SIGHTLINE_TRY(on_message(*message, data, offset - data.size()));
  }
  return {};
}

}  // namespace

bool is_mcap(const std::filesystem::path& path) {
  constexpr std::string_view kSignature = "\x89MCAP";
  const Result<std::string> bytes = read_beginning(path.string(), kSignature.size());
  return bytes && *bytes == kSignature;
}

Result<std::unique_ptr<MessageLog>> open_mcap(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(RandomAccessFile file, RandomAccessFile::open(path));
  auto log = std::make_unique<McapFile>(std::move(file));
  SIGHTLINE_TRY(log->build_index());
  return std::unique_ptr<MessageLog>(std::move(log));
}

}  // namespace sightline
