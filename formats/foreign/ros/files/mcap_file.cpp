#include "formats/foreign/ros/files/open_message_log.h"

#include <zlib.h>

#include <algorithm>
#include <utility>

#include "formats/base/files/regular_file.h"
#include "formats/foreign/ros/files/mcap_index.h"
#include "formats/foreign/ros/files/recent_chunks.h"

namespace sightline {
namespace {

using Bytes = std::vector<std::byte>;
constexpr std::size_t kNoChunk = SIZE_MAX;  // of a message outside of chunks

class McapFile : public MessageLog {
 public:
  explicit McapFile(RandomAccessFile file) : file_(std::move(file)) {}

  Result<void> build_index();
  Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                const MessageBody& body) const override;
  Result<Bytes> read(const MessagePlace& place) const override;

 private:
  using Counts = std::map<std::uint16_t, std::uint64_t>;
  [[nodiscard]] bool needs_unpacking(const McapChunk& chunk) const;
  [[nodiscard]] Result<Bytes> unpack(const McapChunk& chunk) const;
  Result<void> index_chunk(McapChunk& chunk);
  Result<void> name_channels();
  void warn();
  Result<void> check_counts(const McapChunk& chunk, const Counts& found) const;
  [[nodiscard]] Error damaged(const McapChunk& chunk, std::size_t offset,
                              const std::string& message) const;
  template <class OnMessage, class OnDescription>
  Result<void> walk(const McapChunk& chunk, std::span<const std::byte> bytes, OnMessage on_message,
                    OnDescription on_description) const;

  RandomAccessFile file_;
  McapIndex index_;
  mutable RecentChunks recent_;
};

// Where in an unpacked chunk; a packed one has no bytes of the file for it.
Error McapFile::damaged(const McapChunk& chunk, std::size_t offset,
                        const std::string& message) const {
  return file_.error_at(chunk.offset, message + " at byte " + std::to_string(offset) +
                                          " of this chunk's " +
                                          std::to_string(chunk.unpacked_size));
}

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

Result<Bytes> McapFile::unpack(const McapChunk& chunk) const {
  Bytes bytes(static_cast<std::size_t>(chunk.data_size));
  SIGHTLINE_TRY(file_.read(chunk.data_offset, bytes));
  if (chunk.compression != BagCompression::kNone) {
    std::optional<Bytes> unpacked =
        unpack_chunk(chunk.compression, bytes, static_cast<std::size_t>(chunk.unpacked_size));
    if (!unpacked) {
      return file_.error_at(chunk.offset, "found a chunk that does not unpack to the " +
                                              std::to_string(chunk.unpacked_size) +
                                              " bytes that it promises");
    }
    bytes = *std::move(unpacked);
  }
  if (chunk.crc == 0) return bytes;
  const uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  if (crc == chunk.crc) return bytes;
  return file_.error_at(chunk.offset, "found a chunk that its checksum does not bear out");
}

bool McapFile::needs_unpacking(const McapChunk& chunk) const {
  return !chunk.is_indexed || std::ranges::any_of(chunk.message_counts, [&](const auto& entry) {
    return !index_.channels.contains(entry.first);
  });
}

// What stands behind the chunk would have said, and the schemas and channels in it.
Result<void> McapFile::index_chunk(McapChunk& chunk) {
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
    return damaged(chunk, offset,
                   "found a schema or channel that is cut or contradicts one of its number");
  };
  SIGHTLINE_TRY(walk(chunk, bytes, count, add));
  if (chunk.is_indexed) SIGHTLINE_TRY(check_counts(chunk, counts));
  chunk.message_counts = std::move(counts);
  return {};
}

Result<void> McapFile::check_counts(const McapChunk& chunk, const Counts& found) const {
  if (found == chunk.message_counts) return {};
  return file_.error_at(chunk.offset,
                        "found other messages in this chunk than the places behind it say");
}

Result<void> McapFile::name_channels() {
  for (const auto& [id, channel] : index_.channels) {
    const auto schema = index_.schemas.find(channel.schema_id);
    if (schema == index_.schemas.end() && channel.schema_id != 0) {
      return Error{ErrorCode::kMalformedHeader,
                   "found topic " + channel.topic + " of schema " +
                       std::to_string(channel.schema_id) + ", which is not in the file",
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

void McapFile::warn() {
  const std::string name = file_.path().filename().string();
  if (!index_.is_closed) {
    warnings_.push_back(name +
                        ": the recording was not closed; what was written last may be missing");
  }
  std::uint64_t found = 0;
  for (const auto& [id, channel] : channels_) found += channel.message_count;
  if (index_.said_messages.value_or(found) == found) return;
  warnings_.push_back(name + ": found " + std::to_string(found) + " messages, expected " +
                      std::to_string(*index_.said_messages) + "; a part of it may be damaged");
}

Result<void> McapFile::build_index() {
  SIGHTLINE_ASSIGN(index_, read_mcap_index(file_));
  for (McapChunk& chunk : index_.chunks) {
    if (needs_unpacking(chunk)) SIGHTLINE_TRY(index_chunk(chunk));
  }
  SIGHTLINE_TRY(name_channels());
  warn();
  return {};
}

Result<void> McapFile::for_each_message(const std::set<std::uint32_t>& channels,
                                        const MessageBody& body) const {
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

Result<Bytes> McapFile::read(const MessagePlace& place) const {
  if (place.chunk != kNoChunk &&
      index_.chunks.at(place.chunk).compression != BagCompression::kNone) {
    const McapChunk& chunk = index_.chunks[place.chunk];
    return recent_.read({place.chunk, static_cast<std::size_t>(chunk.unpacked_size),
                         static_cast<std::size_t>(place.offset), place.size},
                        [&] { return unpack(chunk); });
  }
  const std::uint64_t begin = place.chunk == kNoChunk ? 0 : index_.chunks[place.chunk].data_offset;
  Bytes message(place.size);
  SIGHTLINE_TRY(file_.read(begin + place.offset, message));
  return message;
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
