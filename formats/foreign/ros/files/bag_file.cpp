#include "formats/foreign/ros/files/open_message_log.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/bag_index.h"
#include "formats/foreign/ros/files/recent_chunks.h"

namespace sightline {

namespace {

using Bytes = std::vector<std::byte>;

// Where in an unpacked chunk; a packed one has no bytes of the file for it.
Error damaged_chunk(const RandomAccessFile& file, const BagChunk& chunk, std::size_t offset,
                    const std::string& message) {
  return file.error_at(chunk.offset, message + " at byte " + std::to_string(offset) +
                                         " of this chunk's " + std::to_string(chunk.unpacked_size));
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
    return file.error_at(chunk.offset, "found " + std::to_string(found[number]) +
                                           " messages of connection " + std::to_string(number) +
                                           " in this chunk, expected " + std::to_string(count));
  }
  if (found.size() == chunk.message_counts.size()) return {};
  return file.error_at(chunk.offset,
                       "found messages of a connection in this chunk that the index does not name");
}

class BagFile : public MessageLog {
 public:
  explicit BagFile(RandomAccessFile file) : file_(std::move(file)) {}
  // Once, before all other functions.
  Result<void> read_index();
  Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                const MessageBody& body) const override;
  Result<Bytes> read(const MessagePlace& place) const override;

 private:
  [[nodiscard]] Result<Bytes> unpack(const BagChunk& chunk) const;
  Result<void> index_chunks();

  RandomAccessFile file_;
  std::vector<BagChunk> chunks_;
  mutable RecentChunks recent_;
};

Result<void> BagFile::read_index() {
  SIGHTLINE_ASSIGN(BagIndex index, read_bag_index(file_));
  channels_ = std::move(index.connections);
  chunks_ = std::move(index.chunks);
  return index.is_there ? Result<void>() : index_chunks();
}

Result<Bytes> BagFile::unpack(const BagChunk& chunk) const {
  Bytes bytes(chunk.data_size);
  SIGHTLINE_TRY(file_.read(chunk.data_offset, bytes));
  if (chunk.compression == BagCompression::kNone) return bytes;
  std::optional<Bytes> unpacked = unpack_chunk(chunk.compression, bytes, chunk.unpacked_size);
  if (unpacked) return *std::move(unpacked);
  return file_.error_at(chunk.offset, "found a chunk that does not unpack to the " +
                                          std::to_string(chunk.unpacked_size) +
                                          " bytes that it promises");
}

// What the index would have said.
Result<void> BagFile::index_chunks() {
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    BagChunk& chunk = chunks_[i];
    SIGHTLINE_ASSIGN(const Bytes bytes, unpack(chunk));
    const auto add_message = [&](const LoggedMessage& message, std::size_t begin) -> Result<void> {
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

Result<void> BagFile::for_each_message(const std::set<std::uint32_t>& channels,
                                       const MessageBody& body) const {
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

Result<Bytes> BagFile::read(const MessagePlace& place) const {
  const BagChunk& chunk = chunks_.at(place.chunk);
  if (chunk.compression != BagCompression::kNone) {
    return recent_.read({place.chunk, chunk.unpacked_size, place.offset, place.size},
                        [&] { return unpack(chunk); });
  }
  Bytes message(place.size);
  SIGHTLINE_TRY(file_.read(chunk.data_offset + place.offset, message));
  return message;
}

}  // namespace

Result<std::unique_ptr<MessageLog>> open_ros1_bag(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(RandomAccessFile file, RandomAccessFile::open(path));
  auto bag = std::make_unique<BagFile>(std::move(file));
  SIGHTLINE_TRY(bag->read_index());
  return std::unique_ptr<MessageLog>(std::move(bag));
}

}  // namespace sightline
