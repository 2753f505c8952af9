#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/result.h"
#include "formats/base/units.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/bag_chunks.h"
#include "formats/foreign/ros/files/open_message_log.h"

namespace sightline {
namespace {

// A ROS 1 bag of format 2.0 is a line of text and records: a header and data, each behind its
// length in 32 bits; the header is a list of fields "name=value", each behind its length too.

// What a record is, by its field "op".
enum class BagOp : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

class BagFields {
 public:
  // Nothing for bytes that are no list of fields. Of two fields of one name the last one counts.
  static std::optional<BagFields> parse(std::span<const std::byte> bytes);

  // Nothing where there is no such field; a number has all bytes of its type and no more.
  [[nodiscard]] std::optional<std::string> text(std::string_view name) const;
  template <class T>
  [[nodiscard]] std::optional<T> number(std::string_view name) const {
    const auto found = values_.find(name);
    if (found == values_.end() || found->second.size() != sizeof(T)) return std::nullopt;
    T value{};
    std::memcpy(&value, found->second.data(), sizeof value);
    return value;
  }
  [[nodiscard]] bool is(BagOp op) const {
    return number<std::uint8_t>("op") == static_cast<std::uint8_t>(op);
  }
  // The field "time": ns since 1970.
  [[nodiscard]] std::optional<std::int64_t> time_ns() const;

 private:
  std::map<std::string, std::string, std::less<>> values_;
};

struct BagRecord {
  BagFields fields;
  std::span<const std::byte> data;
};

// A chunk of records, as it lies in the file.
struct BagChunk {
  std::uint64_t offset = 0;       // of its record, bytes of the file
  std::uint64_t data_offset = 0;  // of what may be packed
  std::uint32_t data_size = 0;
  std::uint32_t unpacked_size = 0;
  BagCompression compression = BagCompression::kNone;
  std::map<std::uint32_t, std::uint32_t> message_counts;  // by connection
};

struct BagIndex {
  std::map<std::uint32_t, LogChannel> connections;
  std::vector<BagChunk> chunks;  // ascending, none within another
  // False: the bag was not closed and has no index; connections and counts are unknown.
  bool is_there = true;
};

// A connection of a record kConnection, and its number; nothing where it lacks one of the two, a
// topic or a type.
struct NumberedConnection {
  std::uint32_t number = 0;
  LogChannel connection;
};

constexpr std::string_view kSignature = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMostHeader = 1U << 12U;  // its longest field is a topic
constexpr std::uint32_t kMostData = 1U << 30U;
constexpr std::size_t kNumberSize = sizeof(std::uint32_t);

// A record whose data were not read.
struct Outline {
  std::uint64_t offset = 0;
  BagFields fields;
  std::uint64_t data_offset = 0;
  std::uint32_t data_size = 0;
  [[nodiscard]] std::uint64_t end() const { return data_offset + data_size; }
};

Error cut(const RandomAccessFile& file, std::uint64_t offset, const std::string& what) {
  return file.error_at(offset, "the bag ends within " + what, ErrorCode::kTruncatedScan);
}

// The length at `offset`, of what lies behind it in the file.
Result<std::uint32_t> read_length(const RandomAccessFile& file, std::uint64_t offset,
                                  std::uint32_t most) {
  std::uint32_t length = 0;
  if (offset > file.size() || file.size() - offset < sizeof length) {
    return cut(file, offset, "a record");
  }
  SIGHTLINE_TRY(file.read(offset, std::as_writable_bytes(std::span(&length, 1))));
  if (length > most) {
    return file.error_at(offset,
                         concat("found a record of ", length, " bytes, expected at most ", most));
  }
  if (length > file.size() - offset - sizeof length) {
    return cut(file, offset, concat("a record of ", length, " bytes"));
  }
  return length;
}

Result<Outline> read_outline(const RandomAccessFile& file, std::uint64_t offset) {
  SIGHTLINE_ASSIGN(const std::uint32_t header_size, read_length(file, offset, kMostHeader));
  std::vector<std::byte> header(header_size);
  SIGHTLINE_TRY(file.read(offset + kNumberSize, header));
  std::optional<BagFields> fields = BagFields::parse(header);
  if (!fields) return file.error_at(offset, "found no record: its header is not a list of fields");
  const std::uint64_t length_offset = offset + kNumberSize + header_size;
  SIGHTLINE_ASSIGN(const std::uint32_t data_size, read_length(file, length_offset, kMostData));
  return Outline{offset, *std::move(fields), length_offset + kNumberSize, data_size};
}

Result<std::vector<std::byte>> read_data(const RandomAccessFile& file, const Outline& record) {
  std::vector<std::byte> data(record.data_size);
  SIGHTLINE_TRY(file.read(record.data_offset, data));
  return data;
}

// The header of the whole bag.
struct BagHeader {
  std::uint64_t index_offset = 0;  // 0: there is none
  std::uint32_t connection_count = 0;
  std::uint32_t chunk_count = 0;
  std::uint64_t end = 0;  // where the first record begins
};

Result<void> check_signature(const RandomAccessFile& file) {
  std::string found(std::min<std::uint64_t>(file.size(), kSignature.size()), '\0');
  SIGHTLINE_TRY(file.read(0, std::as_writable_bytes(std::span(found))));
  if (found == kSignature) return {};
  if (kSignature.starts_with(found)) return cut(file, found.size(), "its first line");
  return file.error_at(0, "expected a bag of format 2.0 (#ROSBAG V2.0)",
                       ErrorCode::kUnsupportedFormat);
}

Result<BagHeader> read_bag_header(const RandomAccessFile& file) {
  SIGHTLINE_TRY(check_signature(file));
  SIGHTLINE_ASSIGN(const Outline record, read_outline(file, kSignature.size()));
  const auto index_offset = record.fields.number<std::uint64_t>("index_pos");
  const auto connections = record.fields.number<std::uint32_t>("conn_count");
  const auto chunks = record.fields.number<std::uint32_t>("chunk_count");
  if (!record.fields.is(BagOp::kBagHeader) || !index_offset || !connections || !chunks) {
    return file.error_at(record.offset, "expected the header of a bag");
  }
  if (!record.fields.text("encryptor").value_or("").empty()) {
    return file.error_at(record.offset, "the bag is encrypted", ErrorCode::kUnsupportedFormat);
  }
  return BagHeader{*index_offset, *connections, *chunks, record.end()};
}

Result<BagChunk> chunk_of(const RandomAccessFile& file, const Outline& record) {
  const auto size = record.fields.number<std::uint32_t>("size");
  const auto name = record.fields.text("compression");
  if (!record.fields.is(BagOp::kChunk) || !size || !name) {
    return file.error_at(record.offset, "expected a chunk");
  }
  const std::optional<BagCompression> compression = bag_compression_named(*name);
  if (!compression) {
    return file.error_at(record.offset,
                         "found a chunk with a compression other than none, bz2 and lz4",
                         ErrorCode::kUnsupportedFormat);
  }
  const bool is_packed = *compression != BagCompression::kNone;
  if (is_packed ? *size > most_unpacked(record.data_size) : *size != record.data_size) {
    return file.error_at(record.offset, concat("found a chunk of ", *size, " bytes in ",
                                               record.data_size, " bytes of ", *name));
  }
  return BagChunk{record.offset, record.data_offset, record.data_size, *size, *compression, {}};
}

std::optional<NumberedConnection> connection_of(const BagFields& fields,
                                                std::span<const std::byte> data) {
  if (!fields.is(BagOp::kConnection)) return std::nullopt;
  const auto number = fields.number<std::uint32_t>("conn");
  std::optional<std::string> topic = fields.text("topic");
  const std::optional<BagFields> described = BagFields::parse(data);
  if (!number || !topic || !described) return std::nullopt;
  std::optional<std::string> type = described->text("type");
  if (!type) return std::nullopt;
  return NumberedConnection{*number,
                            {*std::move(topic), *std::move(type), MessageEncoding::kRos1, 0}};
}

Result<void> add_connection(const RandomAccessFile& file, const Outline& record, BagIndex& index) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data, read_data(file, record));
  std::optional<NumberedConnection> found = connection_of(record.fields, data);
  if (!found) return file.error_at(record.offset, "expected a connection with a topic and a type");
  const bool is_new = index.connections.emplace(found->number, std::move(found->connection)).second;
  if (!is_new) {
    return file.error_at(record.offset, concat("found connection ", found->number, " twice"));
  }
  return {};
}

// Pairs of a connection and how many messages of it there are.
Result<void> set_counts(const RandomAccessFile& file, const Outline& record, BagChunk& chunk) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data, read_data(file, record));
  const auto count = record.fields.number<std::uint32_t>("count");
  if (!count || data.size() != std::uint64_t{*count} * 2 * kNumberSize) {
    return file.error_at(record.offset,
                         concat("found ", data.size(),
                                " bytes of counts, expected 8 for each connection of the chunk"));
  }
  for (std::size_t i = 0; i < data.size(); i += 2 * kNumberSize) {
    std::uint32_t pair[2] = {};
    std::memcpy(pair, data.data() + i, sizeof pair);
    chunk.message_counts[pair[0]] += pair[1];
  }
  return {};
}

// Behind a chunk stands, for each connection in it, where its messages lie.
Result<void> check_counts(const RandomAccessFile& file, const BagChunk& chunk) {
  constexpr std::uint64_t kEntrySize = 12;
  std::map<std::uint32_t, std::uint32_t> counts;
  std::uint64_t offset = chunk.data_offset + chunk.data_size;
  for (std::size_t i = 0; i < chunk.message_counts.size(); ++i) {
    SIGHTLINE_ASSIGN(const Outline record, read_outline(file, offset));
    const auto version = record.fields.number<std::uint32_t>("ver");
    const auto connection = record.fields.number<std::uint32_t>("conn");
    const auto count = record.fields.number<std::uint32_t>("count");
    if (!record.fields.is(BagOp::kIndexData) || version != 1U || !connection || !count ||
        record.data_size != *count * kEntrySize) {
      return file.error_at(offset, "expected the index of a chunk's messages in version 1");
    }
    counts[*connection] = *count;
    offset = record.end();
  }
  if (counts == chunk.message_counts) return {};
  return file.error_at(chunk.offset,
                       "the bag's index and the index after this chunk list different messages");
}

Result<BagChunk> described_chunk(const RandomAccessFile& file, const Outline& record) {
  const auto version = record.fields.number<std::uint32_t>("ver");
  const auto offset = record.fields.number<std::uint64_t>("chunk_pos");
  if (!record.fields.is(BagOp::kChunkInfo) || version != 1U || !offset) {
    return file.error_at(record.offset, "expected the record of a chunk's position in version 1");
  }
  SIGHTLINE_ASSIGN(const Outline at, read_outline(file, *offset));
  SIGHTLINE_ASSIGN(BagChunk chunk, chunk_of(file, at));
  SIGHTLINE_TRY(set_counts(file, record, chunk));
  SIGHTLINE_TRY(check_counts(file, chunk));
  return chunk;
}

// Chunks ascend and lie apart, so that no byte of the file is unpacked twice; messages are of
// connections that there are.
Result<void> join(const RandomAccessFile& file, BagIndex& index) {
  std::ranges::sort(index.chunks, {}, &BagChunk::offset);
  std::uint64_t end = 0;
  for (const BagChunk& chunk : index.chunks) {
    if (chunk.offset < end) {
      return file.error_at(chunk.offset, "found a chunk within the one before");
    }
    end = chunk.data_offset + chunk.data_size;
    for (const auto& [number, count] : chunk.message_counts) {
      const auto found = index.connections.find(number);
      if (found == index.connections.end()) {
        return file.error_at(chunk.offset, concat("found a chunk of connection ", number,
                                                  ", which is not in the index"));
      }
      found->second.message_count += count;
    }
  }
  return {};
}

Result<BagIndex> read_index(const RandomAccessFile& file, const BagHeader& header) {
  BagIndex index;
  std::uint64_t offset = header.index_offset;
  for (std::uint32_t i = 0; i < header.connection_count; ++i) {
    SIGHTLINE_ASSIGN(const Outline record, read_outline(file, offset));
    SIGHTLINE_TRY(add_connection(file, record, index));
    offset = record.end();
  }
  for (std::uint32_t i = 0; i < header.chunk_count; ++i) {
    SIGHTLINE_ASSIGN(const Outline record, read_outline(file, offset));
    SIGHTLINE_ASSIGN(BagChunk chunk, described_chunk(file, record));
    index.chunks.push_back(std::move(chunk));
    offset = record.end();
  }
  SIGHTLINE_TRY(join(file, index));
  if (offset == file.size()) return index;
  return file.error_at(offset, concat("found ", file.size() - offset, " bytes after the index of ",
                                      header.chunk_count, " chunks"));
}

// Of a bag that was not closed: every chunk that there is.
Result<BagIndex> find_chunks(const RandomAccessFile& file, const BagHeader& header) {
  BagIndex index;
  index.is_there = false;
  for (std::uint64_t offset = header.end; offset < file.size();) {
    SIGHTLINE_ASSIGN(const Outline record, read_outline(file, offset));
    offset = record.end();
    const bool is_passed_over = record.fields.is(BagOp::kIndexData) ||
                                record.fields.is(BagOp::kConnection) ||
                                record.fields.is(BagOp::kChunkInfo);
    if (is_passed_over) continue;
    SIGHTLINE_ASSIGN(BagChunk chunk, chunk_of(file, record));
    index.chunks.push_back(std::move(chunk));
  }
  return index;
}

// What stands behind the length at `offset`, and sets `offset` behind it.
std::optional<std::span<const std::byte>> take_sized(std::span<const std::byte> bytes,
                                                     std::size_t& offset) {
  std::uint32_t size = 0;
  if (bytes.size() - offset < sizeof size) return std::nullopt;
  std::memcpy(&size, bytes.data() + offset, sizeof size);
  if (size > bytes.size() - offset - sizeof size) return std::nullopt;
  const std::span<const std::byte> taken = bytes.subspan(offset + sizeof size, size);
  offset += sizeof size + size;
  return taken;
}

// Errors: those of MessageLog.
Result<BagIndex> read_bag_index(const RandomAccessFile& file) {
  SIGHTLINE_ASSIGN(const BagHeader header, read_bag_header(file));
  if (header.index_offset == 0) {
    Result<BagIndex> found = find_chunks(file, header);
    if (found) return found;
    Error error = found.error();
    error.message += "; the bag was not closed: run `rosbag reindex` on it";
    return error;
  }
  return read_index(file, header);
}

std::optional<BagFields> BagFields::parse(std::span<const std::byte> bytes) {
  BagFields fields;
  for (std::size_t offset = 0; offset < bytes.size();) {
    const auto field = take_sized(bytes, offset);
    if (!field) return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(field->data()), field->size());
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    fields.values_[std::string(text.substr(0, equals))] = text.substr(equals + 1);
  }
  return fields;
}

std::optional<std::string> BagFields::text(std::string_view name) const {
  const auto found = values_.find(name);
  return found == values_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<std::int64_t> BagFields::time_ns() const {
  const auto time = number<std::uint64_t>("time");
  if (!time) return std::nullopt;
  const auto seconds = static_cast<std::int64_t>(*time & 0xffff'ffffU);
  return seconds * kSecond_ns + static_cast<std::int64_t>(*time >> 32U);
}

// The record at `offset` of bytes in memory, and sets `offset` behind it; nothing where there is
// none that lies within the bytes.
std::optional<BagRecord> take_bag_record(std::span<const std::byte> bytes, std::size_t& offset) {
  std::size_t at = offset;
  const auto header = take_sized(bytes, at);
  const auto data = header ? take_sized(bytes, at) : std::nullopt;
  if (!data) return std::nullopt;
  std::optional<BagFields> fields = BagFields::parse(*header);
  if (!fields) return std::nullopt;
  offset = at;
  return BagRecord{*std::move(fields), *data};
}

using Bytes = std::vector<std::byte>;

// Where in an unpacked chunk; a packed one has no bytes of the file for it.
Error damaged_chunk(const RandomAccessFile& file, const BagChunk& chunk, std::size_t offset,
                    const std::string& message) {
  return file.error_at(
      chunk.offset, concat(message, " at byte ", offset, " of this chunk's ", chunk.unpacked_size));
}

// The record of a message, and where its bytes lie.
std::optional<LoggedMessage> message_of(const BagRecord& record, std::size_t chunk,
                                        std::size_t end) {
  const auto connection = record.fields.number<std::uint32_t>("conn");
  const auto time_ns = record.fields.time_ns();
  if (!record.fields.is(BagOp::kMessage) || !connection || !time_ns) return std::nullopt;
  const std::size_t size = record.data.size();
  return LoggedMessage{*connection, *time_ns, {0, chunk, end - size, size}, record.data};
}

// Calls on_message(message) and on_connection(connection) for the records of a chunk; the functions
// return a Result<void>.
template <class OnMessage, class OnConnection>
Result<void> walk(const RandomAccessFile& file, std::span<const BagChunk> chunks, std::size_t i,
                  std::span<const std::byte> bytes, OnMessage on_message,
                  OnConnection on_connection) {
  for (std::size_t offset = 0; offset < bytes.size();) {
    const std::size_t begin = offset;
    const std::optional<BagRecord> record = take_bag_record(bytes, offset);
    if (!record) return damaged_chunk(file, chunks[i], begin, "found no record");
    if (std::optional<NumberedConnection> connection =
            connection_of(record->fields, record->data)) {
      SIGHTLINE_TRY(on_connection(*std::move(connection), begin));
      continue;
    }
    const std::optional<LoggedMessage> message = message_of(*record, i, offset);
    if (!message) return damaged_chunk(file, chunks[i], begin, "expected a message");
    SIGHTLINE_TRY(on_message(*message, begin));
  }
  return {};
}

bool holds_any(const BagChunk& chunk, const std::set<std::uint32_t>& connections) {
  return std::ranges::any_of(chunk.message_counts,
                             [&](const auto& entry) { return connections.contains(entry.first); });
}

// What the index said of a chunk is what was found in it.
Result<void> check_counts(const RandomAccessFile& file, const BagChunk& chunk,
                          std::map<std::uint32_t, std::uint32_t> found) {
  for (const auto& [number, count] : chunk.message_counts) {
    if (found[number] == count) continue;
    return file.error_at(chunk.offset, concat("found ", found[number], " messages of connection ",
                                              number, " in this chunk, expected ", count));
  }
  if (found.size() == chunk.message_counts.size()) return {};
  return file.error_at(chunk.offset,
                       "found messages of a connection in this chunk that the index does not name");
}

class BagFile : public MessageLog {
 public:
  explicit BagFile(RandomAccessFile file) : file_(std::move(file)) {}
  // Once, before all other functions.
  Result<void> read_index() {
    SIGHTLINE_ASSIGN(BagIndex index, read_bag_index(file_));
    channels_ = std::move(index.connections);
    chunks_ = std::move(index.chunks);
    return index.is_there ? Result<void>() : index_chunks();
  }

  Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                const MessageBody& body) const override {
    for (std::size_t i = 0; i < chunks_.size(); ++i) {
      if (!holds_any(chunks_[i], channels)) continue;
      SIGHTLINE_ASSIGN(const Bytes bytes, unpack(chunks_[i]));
      std::map<std::uint32_t, std::uint32_t> found;
      const auto visit = [&](const LoggedMessage& message, std::size_t /*begin*/) -> Result<void> {
        ++found[message.channel];
        return channels.contains(message.channel) ? body(message) : Result<void>();
      };
      const auto pass_over = [](const NumberedConnection&, std::size_t) { return Result<void>(); };
      SIGHTLINE_TRY(walk(file_, chunks_, i, bytes, visit, pass_over));
      SIGHTLINE_TRY(check_counts(file_, chunks_[i], std::move(found)));
    }
    return {};
  }

  Result<Bytes> read(const MessagePlace& place) const override {
    const BagChunk& chunk = chunks_.at(place.chunk);
    if (chunk.compression != BagCompression::kNone) {
      return recent_.read({place.chunk, chunk.unpacked_size, place.offset, place.size},
                          [&] { return unpack(chunk); });
    }
    Bytes message(place.size);
    SIGHTLINE_TRY(file_.read(chunk.data_offset + place.offset, message));
    return message;
  }

 private:
  [[nodiscard]] Result<Bytes> unpack(const BagChunk& chunk) const {
    Bytes bytes(chunk.data_size);
    SIGHTLINE_TRY(file_.read(chunk.data_offset, bytes));
    if (chunk.compression == BagCompression::kNone) return bytes;
    std::optional<Bytes> unpacked = unpack_chunk(chunk.compression, bytes, chunk.unpacked_size);
    if (unpacked) return *std::move(unpacked);
    return file_.error_at(chunk.offset, concat("found a chunk that does not unpack to the ",
                                               chunk.unpacked_size, " bytes of its header"));
  }

  // What the index would have said.
  Result<void> index_chunks() {
    for (std::size_t i = 0; i < chunks_.size(); ++i) {
      BagChunk& chunk = chunks_[i];
      SIGHTLINE_ASSIGN(const Bytes bytes, unpack(chunk));
      const auto add_message = [&](const LoggedMessage& message,
                                   std::size_t begin) -> Result<void> {
        const auto connection = channels_.find(message.channel);
        if (connection == channels_.end()) {
          return damaged_chunk(file_, chunk, begin, "found a message before its connection");
        }
        ++connection->second.message_count;
        ++chunk.message_counts[message.channel];
        return {};
      };
      // Every chunk may tell of a connection anew.
      const auto add_connection = [&](NumberedConnection found, std::size_t begin) -> Result<void> {
        const auto [entry, is_new] = channels_.emplace(found.number, found.connection);
        if (is_new || (entry->second.topic == found.connection.topic &&
                       entry->second.type == found.connection.type)) {
          return {};
        }
        return damaged_chunk(file_, chunk, begin, "found two connections of one number");
      };
      SIGHTLINE_TRY(walk(file_, chunks_, i, bytes, add_message, add_connection));
    }
    return {};
  }

  RandomAccessFile file_;
  std::vector<BagChunk> chunks_;
  mutable RecentChunks recent_;
};

}  // namespace

Result<std::unique_ptr<MessageLog>> open_ros1_bag(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(RandomAccessFile file, RandomAccessFile::open(path));
  auto bag = std::make_unique<BagFile>(std::move(file));
  SIGHTLINE_TRY(bag->read_index());
  return std::unique_ptr<MessageLog>(std::move(bag));
}

}  // namespace sightline
