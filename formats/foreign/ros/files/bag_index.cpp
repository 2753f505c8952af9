#include "formats/foreign/ros/files/bag_index.h"

#include <algorithm>
#include <utility>

#include "formats/base/units.h"

// A closed bag ends with its index: a record for each connection, and one for each chunk that lists
// where it lies and how many messages of which connection it holds. Behind a chunk stands the place
// of each message in it (kIndexData); only their count is used, since a chunk that is unpacked is
// cheap to walk through, and a place that is not believed cannot be wrong.

namespace sightline {
namespace {

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
    return file.error_at(offset, "found a record of " + std::to_string(length) +
                                     " bytes, expected at most " + std::to_string(most));
  }
  if (length > file.size() - offset - sizeof length) {
    return cut(file, offset, "a record of " + std::to_string(length) + " bytes");
  }
  return length;
}

Result<Outline> read_outline(const RandomAccessFile& file, std::uint64_t offset) {
  SIGHTLINE_ASSIGN(const std::uint32_t header_size, read_length(file, offset, kMostHeader));
  std::vector<std::byte> header(header_size);
  SIGHTLINE_TRY(file.read(offset + kNumberSize, header));
  std::optional<BagFields> fields = BagFields::parse(header);
  if (!fields) return file.error_at(offset, "found no record, its header is no list of fields");
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
    return file.error_at(record.offset, "found a chunk of " + std::to_string(*size) + " bytes in " +
                                            std::to_string(record.data_size) + " bytes of " +
                                            *name);
  }
  return BagChunk{record.offset, record.data_offset, record.data_size, *size, *compression, {}};
}

Result<void> add_connection(const RandomAccessFile& file, const Outline& record, BagIndex& index) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data, read_data(file, record));
  std::optional<NumberedConnection> found = connection_of(record.fields, data);
  if (!found) {
    return file.error_at(record.offset, "expected a connection with a topic and a type");
  }
  const bool is_new = index.connections.emplace(found->number, std::move(found->connection)).second;
  if (!is_new) {
    return file.error_at(record.offset,
                         "found connection " + std::to_string(found->number) + " twice");
  }
  return {};
}

// Pairs of a connection and how many messages of it there are.
Result<void> set_counts(const RandomAccessFile& file, const Outline& record, BagChunk& chunk) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> data, read_data(file, record));
  const auto count = record.fields.number<std::uint32_t>("count");
  if (!count || data.size() != std::uint64_t{*count} * 2 * kNumberSize) {
    return file.error_at(record.offset,
                         "found " + std::to_string(data.size()) +
                             " bytes of counts, expected 8 for each connection of the chunk");
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
      return file.error_at(offset, "expected where messages of a chunk lie, in version 1");
    }
    counts[*connection] = *count;
    offset = record.end();
  }
  if (counts == chunk.message_counts) return {};
  return file.error_at(chunk.offset,
                       "the bag's index and what stands behind this chunk differ in its messages");
}

Result<BagChunk> described_chunk(const RandomAccessFile& file, const Outline& record) {
  const auto version = record.fields.number<std::uint32_t>("ver");
  const auto offset = record.fields.number<std::uint64_t>("chunk_pos");
  if (!record.fields.is(BagOp::kChunkInfo) || version != 1U || !offset) {
    return file.error_at(record.offset, "expected where a chunk lies, in version 1");
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
        return file.error_at(chunk.offset, "found a chunk of connection " + std::to_string(number) +
                                               ", which is not in the index");
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
  return file.error_at(offset, "found " + std::to_string(file.size() - offset) +
                                   " bytes behind the index of " +
                                   std::to_string(header.chunk_count) + " chunks");
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

}  // namespace

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

Result<BagIndex> read_bag_index(const RandomAccessFile& file) {
  SIGHTLINE_ASSIGN(const BagHeader header, read_bag_header(file));
  if (header.index_offset == 0) {
    Result<BagIndex> found = find_chunks(file, header);
    if (found) return found;
    Error error = found.error();
    error.message += "; the bag was not closed, run `rosbag reindex` on it";
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

}  // namespace sightline
