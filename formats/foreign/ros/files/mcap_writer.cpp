#include "formats/foreign/ros/files/mcap_writer.h"

#include <zlib.h>

#include <algorithm>
#include <utility>

#include "formats/base/version.h"

namespace sightline {
namespace {

using namespace std::string_view_literals;

// Kinds of records (mcap.dev/spec): each is a kind, the length of what follows in 64 bits, and
// fields one after the other, little-endian.
enum class Op : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

constexpr std::string_view kMagic = "\x89MCAP0\r\n"sv;
constexpr std::size_t kChunk_bytes = std::size_t{1} << 20U;  // a reader unpacks so much at once
constexpr std::string_view kNotPacked = "";

std::uint32_t crc_of(std::uint32_t before, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

void put_text(ByteWriter& fields, std::string_view text) {
  fields.put(static_cast<std::uint32_t>(text.size()));
  fields.append(text.data(), text.size());
}

std::vector<std::byte> record(Op op, const ByteWriter& fields) {
  ByteWriter writer;
  writer.put(op);
  writer.put<std::uint64_t>(fields.count());
  writer.append(fields.bytes().data(), fields.count());
  return writer.take();
}

void append(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

}  // namespace

void McapWriter::TimeSpan::add(std::int64_t time_ns) {
  first_ns = is_empty ? time_ns : std::min(first_ns, time_ns);
  last_ns = is_empty ? time_ns : std::max(last_ns, time_ns);
  is_empty = false;
}

std::uint16_t McapWriter::add_topic(const std::string& topic, const McapType& type) {
  const auto known = std::ranges::find(types_, type.name, &Type::name);
  const auto type_id = static_cast<std::uint16_t>(known - types_.begin() + 1);
  if (known == types_.end()) {
    ByteWriter schema;
    schema.put(type_id);
    put_text(schema, type.name);
    put_text(schema, type.definition_encoding);
    put_text(schema, type.definition);
    types_.push_back({std::string(type.name), record(Op::kSchema, schema)});
  }
  const auto id = static_cast<std::uint16_t>(topics_.size());
  ByteWriter channel;
  channel.put(id);
  channel.put(type_id);
  put_text(channel, topic);
  put_text(channel, type.message_encoding);
  put_text(channel, "");  // no metadata
  Topic& added = topics_.emplace_back();
  added.record = record(Op::kChannel, channel);
  append(chunk_, types_[type_id - 1].record);
  append(chunk_, added.record);
  return id;
}

Result<void> McapWriter::put(std::span<const std::byte> bytes) {
  crc_ = crc_of(crc_, bytes);
  size_ += bytes.size();
  return file_(bytes);
}

Result<void> McapWriter::begin() {
  if (size_ > 0) return {};
  SIGHTLINE_TRY(put(bytes_of(kMagic)));
  ByteWriter header;
  put_text(header, profile_);
  put_text(header, "sightline " + program_version());
  return put(record(Op::kHeader, header));
}

Result<void> McapWriter::add(std::uint16_t topic, std::int64_t time_ns,
                             std::span<const std::byte> message) {
  Topic& on = topics_[topic];
  on.in_chunk.emplace_back(time_ns, chunk_.size());
  ByteWriter fields;
  fields.put(topic);
  fields.put(static_cast<std::uint32_t>(on.message_count++));
  fields.put(time_ns);  // of the log
  fields.put(time_ns);  // of its publication
  fields.append(message.data(), message.size());
  append(chunk_, record(Op::kMessage, fields));
  chunk_times_.add(time_ns);
  times_.add(time_ns);
  return chunk_.size() < kChunk_bytes ? Result<void>() : end_chunk();
}

std::vector<std::byte> McapWriter::chunk_record() const {
  ByteWriter chunk;
  chunk.put(chunk_times_.first_ns);
  chunk.put(chunk_times_.last_ns);
  chunk.put<std::uint64_t>(chunk_.size());
  chunk.put(crc_of(0, chunk_));
  put_text(chunk, kNotPacked);
  chunk.put<std::uint64_t>(chunk_.size());
  chunk.append(chunk_.data(), chunk_.size());
  return record(Op::kChunk, chunk);
}

std::vector<std::byte> McapWriter::take_index(std::uint16_t id, Topic& topic) {
  std::ranges::sort(topic.in_chunk);
  ByteWriter index;
  index.put(id);
  index.put(static_cast<std::uint32_t>(topic.in_chunk.size() * 2 * sizeof(std::uint64_t)));
  for (const auto& [time_ns, offset] : topic.in_chunk) {
    index.put(time_ns);
    index.put(offset);
  }
  topic.in_chunk.clear();
  return record(Op::kMessageIndex, index);
}

Result<void> McapWriter::end_chunk() {
  SIGHTLINE_TRY(begin());
  const std::vector<std::byte> chunk = chunk_record();
  ByteWriter places;  // of the indexes, by topic
  std::vector<std::byte> indexes;
  for (std::size_t id = 0; id < topics_.size(); ++id) {
    if (topics_[id].in_chunk.empty()) continue;
    places.put(static_cast<std::uint16_t>(id));
    places.put<std::uint64_t>(size_ + chunk.size() + indexes.size());
    append(indexes, take_index(static_cast<std::uint16_t>(id), topics_[id]));
  }
  ByteWriter entry;
  entry.put(chunk_times_.first_ns);
  entry.put(chunk_times_.last_ns);
  entry.put(size_);
  entry.put<std::uint64_t>(chunk.size());
  entry.put(static_cast<std::uint32_t>(places.count()));
  entry.append(places.bytes().data(), places.count());
  entry.put<std::uint64_t>(indexes.size());
  put_text(entry, kNotPacked);
  entry.put<std::uint64_t>(chunk_.size());  // as it lies
  entry.put<std::uint64_t>(chunk_.size());
  chunk_indexes_.push_back(record(Op::kChunkIndex, entry));
  chunk_.clear();
  chunk_times_ = {};
  SIGHTLINE_TRY(put(chunk));
  return put(indexes);
}

std::vector<std::byte> McapWriter::statistics() const {
  std::uint64_t message_count = 0;
  ByteWriter counts;
  for (std::size_t id = 0; id < topics_.size(); ++id) {
    message_count += topics_[id].message_count;
    counts.put(static_cast<std::uint16_t>(id));
    counts.put(topics_[id].message_count);
  }
  ByteWriter fields;
  fields.put(message_count);
  fields.put(static_cast<std::uint16_t>(types_.size()));
  fields.put(static_cast<std::uint32_t>(topics_.size()));
  fields.put<std::uint32_t>(0);  // attachments
  fields.put<std::uint32_t>(0);  // metadata
  fields.put(static_cast<std::uint32_t>(chunk_indexes_.size()));
  fields.put(times_.first_ns);
  fields.put(times_.last_ns);
  fields.put(static_cast<std::uint32_t>(counts.count()));
  fields.append(counts.bytes().data(), counts.count());
  return record(Op::kStatistics, fields);
}

std::vector<std::byte> McapWriter::summary() const {
  std::vector<std::vector<std::byte>> schemas;
  for (const Type& type : types_) schemas.push_back(type.record);
  std::vector<std::vector<std::byte>> channels;
  for (const Topic& topic : topics_) channels.push_back(topic.record);
  const std::pair<Op, std::vector<std::vector<std::byte>>> groups[] = {
      {Op::kSchema, schemas},
      {Op::kChannel, channels},
      {Op::kStatistics, {statistics()}},
      {Op::kChunkIndex, chunk_indexes_}};
  std::vector<std::byte> bytes;
  std::vector<std::byte> offsets;
  for (const auto& [op, records] : groups) {
    if (records.empty()) continue;
    const std::uint64_t start = bytes.size();
    for (const std::vector<std::byte>& one : records) append(bytes, one);
    ByteWriter fields;
    fields.put(op);
    fields.put(size_ + start);
    fields.put<std::uint64_t>(bytes.size() - start);
    append(offsets, record(Op::kSummaryOffset, fields));
  }
  // The checksum includes the footer up to its own place.
  ByteWriter footer;
  footer.put(Op::kFooter);
  footer.put<std::uint64_t>(2 * sizeof(std::uint64_t) + sizeof(std::uint32_t));
  footer.put(size_);
  footer.put<std::uint64_t>(size_ + bytes.size());
  append(bytes, offsets);
  append(bytes, footer.bytes());
  return bytes;
}

Result<void> McapWriter::finish() {
  if (!chunk_.empty()) SIGHTLINE_TRY(end_chunk());
  SIGHTLINE_TRY(begin());
  ByteWriter data_end;
  data_end.put(crc_);
  SIGHTLINE_TRY(put(record(Op::kDataEnd, data_end)));
  const std::vector<std::byte> all = summary();
  ByteWriter crc;
  crc.put(crc_of(0, all));
  SIGHTLINE_TRY(put(all));
  SIGHTLINE_TRY(put(crc.bytes()));
  return put(bytes_of(kMagic));
}

}  // namespace sightline
