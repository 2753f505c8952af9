#include "formats/foreign/ros/files/open_message_log.h"

#include <algorithm>
#include <mutex>
#include <string_view>
#include <utility>

#include "formats/base/files/regular_file.h"
#include "formats/foreign/ros/files/sqlite_file.h"

namespace sightline {
namespace {

class Db3File : public MessageLog {
 public:
  explicit Db3File(SqliteFile database) : database_(std::move(database)) {}

  Result<void> build_index();
  Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                const MessageBody& body) const override;
  Result<std::vector<std::byte>> read(const MessagePlace& place) const override;

 private:
  Result<void> add_topics();
  Result<void> count_messages();

  SqliteFile database_;
  std::map<std::int64_t, std::uint32_t> channel_of_topic_;  // by the database's number
  mutable std::mutex mutex_;                                // of the database
};

Result<void> Db3File::add_topics() {
  for (const char* table : {"topics", "messages"}) {
    SIGHTLINE_ASSIGN(const bool is_there, database_.has_table(table));
    if (is_there) continue;
    return Error{
        ErrorCode::kUnsupportedFormat,
        std::string("a database without a table '") + table + "', expected a recording of ros2 bag",
        database_.path().string()};
  }
  return database_.for_each_row(
      "SELECT id, name, type, serialization_format FROM topics",
      [&](const SqliteRow& row) -> Result<void> {
        const auto id = row.integer(0);
        const auto name = row.text(1);
        const auto type = row.text(2);
        const auto format = row.text(3);
        const auto number = static_cast<std::uint32_t>(channels_.size());
        if (!id || !name || !type || !format || !channel_of_topic_.emplace(*id, number).second) {
          return database_.damaged("found a topic without number, name, type or format, or twice");
        }
        // Tools that rewrite recordings leave it out; ros2 bag itself writes nothing but CDR.
        const std::string_view encoding = format->empty() ? "cdr" : std::string_view(*format);
        channels_[number] = {std::string(*name), ros1_type_name(*type), encoding_named(encoding),
                             0};
        return {};
      });
}

Result<void> Db3File::count_messages() {
  std::optional<std::int64_t> before;
  return database_.for_each_row(
      "SELECT rowid, topic_id FROM messages", [&](const SqliteRow& row) -> Result<void> {
        const auto id = row.integer(0);
        const auto topic = row.integer(1);
        // In a sound tree they ascend; in another a message might not be found again.
        if (!id || (before && *id <= *before)) {
          return database_.damaged("found messages whose numbers do not ascend");
        }
        before = id;
        const auto found = channel_of_topic_.find(topic.value_or(0));
        if (!topic || found == channel_of_topic_.end()) {
          return database_.damaged("found message " + std::to_string(*id) +
                                   " of a topic that is not there");
        }
        ++channels_[found->second].message_count;
        return {};
      });
}

Result<void> Db3File::build_index() {
  SIGHTLINE_TRY(add_topics());
  return count_messages();
}

Result<void> Db3File::for_each_message(const std::set<std::uint32_t>& channels,
                                       const MessageBody& body) const {
  std::string topics;
  for (const auto& [topic, channel] : channel_of_topic_) {
    if (!channels.contains(channel)) continue;
    topics += (topics.empty() ? "" : ",") + std::to_string(topic);
  }
  const std::string select =
      "SELECT rowid, topic_id, timestamp, data FROM messages "
      "WHERE topic_id IN (" +
      topics + ") ORDER BY rowid";
  const std::scoped_lock lock(mutex_);
  return database_.for_each_row(select, [&](const SqliteRow& row) -> Result<void> {
    const auto id = row.integer(0);
    const auto topic = row.integer(1);
    const auto time_ns = row.integer(2);
    const auto bytes = row.bytes(3);
    const auto channel = channel_of_topic_.find(topic.value_or(0));
    if (!id || !topic || !time_ns || !bytes || channel == channel_of_topic_.end()) {
      return database_.damaged("found no time or no bytes of message " +
                               std::to_string(id.value_or(0)));
    }
    const MessagePlace place{0, 0, static_cast<std::uint64_t>(*id), bytes->size()};
    return body({channel->second, *time_ns, place, *bytes});
  });
}

Result<std::vector<std::byte>> Db3File::read(const MessagePlace& place) const {
  const std::string id = std::to_string(static_cast<std::int64_t>(place.offset));
  std::vector<std::byte> message;
  bool is_there = false;
  const std::scoped_lock lock(mutex_);
  SIGHTLINE_TRY(database_.for_each_row("SELECT data FROM messages WHERE rowid = " + id,
                                       [&](const SqliteRow& row) -> Result<void> {
                                         const auto bytes = row.bytes(0);
                                         is_there = bytes && bytes->size() == place.size;
                                         if (is_there) message.assign(bytes->begin(), bytes->end());
                                         return {};
                                       }));
  if (is_there) return message;
  return database_.damaged("found message " + id + " in one table and not again");
}

}  // namespace

bool is_db3(const std::filesystem::path& path) {
  using namespace std::string_view_literals;
  constexpr std::string_view kSignature = "SQLite format 3\0"sv;
  constexpr std::size_t kApplicationAt = 68;  // a GeoPackage names itself here
  constexpr std::size_t kApplicationSize = 4;
  const Result<std::string> bytes =
      read_beginning(path.string(), kApplicationAt + kApplicationSize);
  if (!bytes || !bytes->starts_with(kSignature)) return false;
  return bytes->size() < kApplicationAt ||
         bytes->find_first_not_of('\0', kApplicationAt) == std::string::npos;
}

Result<std::unique_ptr<MessageLog>> open_db3(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(SqliteFile database, SqliteFile::open(path));
  auto log = std::make_unique<Db3File>(std::move(database));
  SIGHTLINE_TRY(log->build_index());
  return std::unique_ptr<MessageLog>(std::move(log));
}

}  // namespace sightline
