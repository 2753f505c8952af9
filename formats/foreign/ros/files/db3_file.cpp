#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "formats/base/files/regular_file.h"
#include "formats/base/result.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/open_message_log.h"

namespace sightline {
namespace {

// One row of an answer.
class SqliteRow {
 public:
  explicit SqliteRow(sqlite3_stmt* statement) : statement_(statement) {}

  // Nothing where the column is of another type. Text and bytes are there until the next row.
  [[nodiscard]] std::optional<std::int64_t> integer(int column) const;
  [[nodiscard]] std::optional<std::string_view> text(int column) const;
  [[nodiscard]] std::optional<std::span<const std::byte>> bytes(int column) const;

 private:
  sqlite3_stmt* statement_;
};

// A database of SQLite in a regular file, which is only read: no lock, no journal, nothing is
// written beside it. What it may ask of memory is bounded by its size. Not safe from several
// threads.
class SqliteFile {
 public:
  // Errors: file-not-found, cannot-open, cannot-read, malformed-header, truncated-scan (shorter
  // than its header says). A database that its writer did not close, so that a part of it lies in a
  // journal beside it, is malformed.
  static Result<SqliteFile> open(const std::filesystem::path& path);

  // Whether there is an ordinary table of this name.
  Result<bool> has_table(std::string_view name) const;
  // Calls body(row) for each row of a SELECT of columns of tables (no functions). Errors:
  // malformed-header (damaged, or no such table or column), cannot-read, and those of body.
  using RowBody = std::function<Result<void>(const SqliteRow&)>;
  Result<void> for_each_row(const std::string& select, const RowBody& body) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] Error damaged(std::string message) const;

 private:
  struct Closer {
    void operator()(sqlite3* database) const { sqlite3_close(database); }
  };
  SqliteFile(std::filesystem::path path, std::uint64_t size)
      : path_(std::move(path)), size_(size) {}
  Result<void> connect();
  [[nodiscard]] Error error_of(int status) const;

  std::filesystem::path path_;
  std::uint64_t size_ = 0;  // of the file, bytes
  std::unique_ptr<sqlite3, Closer> database_;
};

constexpr std::size_t kHeaderSize = 100;

// Reading columns and nothing else: no function, no recursion, no other database.
int authorize(void*, int action, const char*, const char*, const char*, const char*) {
  return action == SQLITE_SELECT || action == SQLITE_READ ? SQLITE_OK : SQLITE_DENY;
}

std::uint32_t big_endian(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (const std::byte byte : bytes) value = (value << 8U) + std::to_integer<std::uint32_t>(byte);
  return value;
}

// What SQLite would find too, without the byte.
Result<void> check_size(const RandomAccessFile& file) {
  std::array<std::byte, kHeaderSize> header{};
  if (file.size() < header.size()) {
    return file.error_at(file.size(), "the file ends within the header of its database",
                         ErrorCode::kTruncatedScan);
  }
  SIGHTLINE_TRY(file.read(0, header));
  const std::span<const std::byte> bytes(header);
  const std::uint32_t said_size = big_endian(bytes.subspan(16, 2));
  const std::uint64_t page_size = said_size == 1 ? 65536 : said_size;
  const std::uint64_t pages = big_endian(bytes.subspan(28, 4));
  // Older writers leave the count alone, and then the two counters of changes differ.
  const bool is_count_valid = big_endian(bytes.subspan(24, 4)) == big_endian(bytes.subspan(92, 4));
  if (!is_count_valid || pages * page_size <= file.size()) return {};
  return file.error_at(
      file.size(),
      concat("found ", file.size(), " bytes of a database, expected ", pages * page_size),
      ErrorCode::kTruncatedScan);
}

Result<void> check_was_closed(const std::filesystem::path& path) {
  for (const char* ending : {"-wal", "-journal"}) {
    std::error_code failure;
    const std::filesystem::path beside = path.string() + ending;
    const std::uintmax_t size = std::filesystem::file_size(beside, failure);
    if (failure || size == 0) continue;
    return Error{ErrorCode::kMalformedHeader,
                 concat("the recording was not closed: a part of it is in ",
                        beside.filename().string(), "; `sqlite3 ", path.filename().string(),
                        " 'PRAGMA journal_mode=DELETE'` merges both"),
                 path.string()};
  }
  return {};
}

// SQLite calls these functions instead of the operating system. Its own would follow a pipe, lock
// the file and make files beside it, which a recording on read-only storage does not allow. The
// file is opened as immutable, so neither locks nor journals are used.

struct OpenFile {
  sqlite3_file base;  // first, as SQLite asks for it
  RandomAccessFile* file;
};

RandomAccessFile& file_of(sqlite3_file* file) { return *reinterpret_cast<OpenFile*>(file)->file; }

int close_file(sqlite3_file* file) {
  const std::unique_ptr<RandomAccessFile> owned(reinterpret_cast<OpenFile*>(file)->file);
  return SQLITE_OK;
}

int read_file(sqlite3_file* base, void* to, int size, sqlite3_int64 offset) {
  const RandomAccessFile& file = file_of(base);
  const auto begin = static_cast<std::uint64_t>(offset);
  const std::uint64_t left = begin < file.size() ? file.size() - begin : 0;
  const auto wanted = static_cast<std::uint64_t>(size);
  const std::span<std::byte> bytes(static_cast<std::byte*>(to), wanted);
  const std::uint64_t there = std::min(left, wanted);
  std::ranges::fill(bytes.subspan(there), std::byte{0});  // as SQLite asks for it
  if (!file_of(base).read(begin, bytes.first(there))) return SQLITE_IOERR_READ;
  return there == wanted ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
}

int file_size(sqlite3_file* file, sqlite3_int64* size) {
  *size = static_cast<sqlite3_int64>(file_of(file).size());
  return SQLITE_OK;
}

int is_reserved(sqlite3_file*, int* answer) {
  *answer = 0;
  return SQLITE_OK;
}
const sqlite3_io_methods& methods() {
  static const sqlite3_io_methods kMethods = [] {
    sqlite3_io_methods made{};
    made.iVersion = 1;
    made.xClose = close_file;
    made.xRead = read_file;
    made.xWrite = [](sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; };
    made.xTruncate = [](sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; };
    made.xSync = [](sqlite3_file*, int) { return SQLITE_OK; };
    made.xFileSize = file_size;
    made.xLock = made.xSync;
    made.xUnlock = made.xSync;
    made.xCheckReservedLock = is_reserved;
    made.xFileControl = [](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
    made.xSectorSize = [](sqlite3_file*) { return 4096; };
    made.xDeviceCharacteristics = [](sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; };
    return made;
  }();
  return kMethods;
}

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  file->pMethods = nullptr;
  if (name == nullptr || (flags & SQLITE_OPEN_MAIN_DB) == 0) return SQLITE_CANTOPEN;
  Result<RandomAccessFile> opened = RandomAccessFile::open(name);
  if (!opened) return SQLITE_CANTOPEN;
  auto* made = reinterpret_cast<OpenFile*>(file);
  made->file = new (std::nothrow) RandomAccessFile(*std::move(opened));
  if (made->file == nullptr) return SQLITE_NOMEM;
  made->base.pMethods = &methods();
  if (out_flags != nullptr) *out_flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_MAIN_DB;
  return SQLITE_OK;
}

int nothing_is_there(sqlite3_vfs*, const char*, int, int* answer) {
  *answer = 0;
  return SQLITE_OK;
}

int full_name(sqlite3_vfs*, const char* name, int size, char* to) {
  const std::size_t length = std::strlen(name) + 1;
  if (length > static_cast<std::size_t>(size)) return SQLITE_CANTOPEN;
  std::memcpy(to, name, length);
  return SQLITE_OK;
}

int no_randomness(sqlite3_vfs*, int size, char* to) {
  std::memset(to, 0, static_cast<std::size_t>(size));
  return size;
}
int no_time(sqlite3_vfs*, double* days) {
  *days = 0.0;
  return SQLITE_OK;
}
sqlite3_vfs made_vfs() {
  constexpr int kLongestPath = 4096;
  sqlite3_vfs made{};
  made.iVersion = 1;
  made.szOsFile = sizeof(OpenFile);
  made.mxPathname = kLongestPath;
  made.zName = "sightline-read-only";
  made.xOpen = open_file;
  made.xDelete = [](sqlite3_vfs*, const char*, int) { return SQLITE_READONLY; };
  made.xAccess = nothing_is_there;
  made.xFullPathname = full_name;
  made.xRandomness = no_randomness;
  made.xSleep = [](sqlite3_vfs*, int) { return 0; };
  made.xCurrentTime = no_time;
  made.xGetLastError = [](sqlite3_vfs*, int, char*) { return 0; };
  return made;
}

// The name of a file system for SQLite in which regular files are read and nothing else is done;
// registered at the first call.
const char* read_only_vfs() {
  static sqlite3_vfs vfs = made_vfs();
  static const int kRegistered = sqlite3_vfs_register(&vfs, /*makeDflt=*/0);
  return kRegistered == SQLITE_OK ? vfs.zName : nullptr;
}

std::optional<std::int64_t> SqliteRow::integer(int column) const {
  if (sqlite3_column_type(statement_, column) != SQLITE_INTEGER) return std::nullopt;
  return sqlite3_column_int64(statement_, column);
}

std::optional<std::string_view> SqliteRow::text(int column) const {
  if (sqlite3_column_type(statement_, column) != SQLITE_TEXT) return std::nullopt;
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  if (text == nullptr) return std::nullopt;
  return std::string_view(text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
}

std::optional<std::span<const std::byte>> SqliteRow::bytes(int column) const {
  if (sqlite3_column_type(statement_, column) != SQLITE_BLOB) return std::nullopt;
  const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(statement_, column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  return std::span<const std::byte>(data, data == nullptr ? 0 : size);
}

Error SqliteFile::damaged(std::string message) const {
  return {ErrorCode::kMalformedHeader, std::move(message), path_.string()};
}

Error SqliteFile::error_of(int status) const {
  const std::string why = sqlite3_errmsg(database_.get());
  if ((status & 0xff) == SQLITE_IOERR) {
    return {ErrorCode::kCannotRead, "cannot read the database: " + why, path_.string()};
  }
  return damaged("the database cannot be read: " + why);
}

Result<SqliteFile> SqliteFile::open(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const RandomAccessFile file, RandomAccessFile::open(path));
  SIGHTLINE_TRY(check_size(file));
  SIGHTLINE_TRY(check_was_closed(path));
  SqliteFile database(path, file.size());
  SIGHTLINE_TRY(database.connect());
  return database;
}

Result<void> SqliteFile::connect() {
  constexpr std::uint64_t kMostValue = 1U << 30U;
  constexpr std::uint64_t kLeastValue = 1U << 16U;  // for its own work on small databases
  sqlite3* opened = nullptr;
  const int status = sqlite3_open_v2(path_.c_str(), &opened,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, read_only_vfs());
  database_.reset(opened);
  if (opened == nullptr) return damaged("no memory for the database");
  if (status != SQLITE_OK) return error_of(status);
  sqlite3_limit(opened, SQLITE_LIMIT_LENGTH,
                static_cast<int>(std::clamp(size_, kLeastValue, kMostValue)));
  sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_set_authorizer(opened, authorize, nullptr);
  return {};
}

Result<bool> SqliteFile::has_table(std::string_view name) const {
  bool is_there = false;
  SIGHTLINE_TRY(for_each_row(
      "SELECT type, name, rootpage FROM sqlite_master", [&](const SqliteRow& row) -> Result<void> {
        // A virtual table has no page.
        const bool is_table = row.text(0) == "table" && row.integer(2).value_or(0) > 0;
        is_there = is_there || (is_table && row.text(1) == name);
        return {};
      }));
  return is_there;
}

Result<void> SqliteFile::for_each_row(const std::string& select, const RowBody& body) const {
  sqlite3_stmt* made = nullptr;
  const int prepared = sqlite3_prepare_v2(database_.get(), select.c_str(),
                                          static_cast<int>(select.size()), &made, nullptr);
  const std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)> statement(made,
                                                                             &sqlite3_finalize);
  if (prepared != SQLITE_OK) return error_of(prepared);
  // A damaged tree may lead to one page many times; each row has its bytes but once.
  constexpr std::uint64_t kLeastRow = 4;
  for (std::uint64_t rows = 0; rows <= size_ / kLeastRow; ++rows) {
    const int status = sqlite3_step(statement.get());
    if (status == SQLITE_DONE) return {};
    if (status != SQLITE_ROW) return error_of(status);
    SIGHTLINE_TRY(body(SqliteRow(statement.get())));
  }
  return damaged("found more rows than the file can hold");
}

class Db3File : public MessageLog {
 public:
  explicit Db3File(SqliteFile database) : database_(std::move(database)) {}

  Result<void> build_index() {
    SIGHTLINE_TRY(add_topics());
    return count_messages();
  }

  Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                const MessageBody& body) const override {
    std::string topics;
    for (const auto& [topic, channel] : channel_of_topic_) {
      if (!channels.contains(channel)) continue;
      topics += concat((topics.empty() ? "" : ","), topic);
    }
    const std::string select = concat(
        "SELECT rowid, topic_id, timestamp, data FROM messages "
        "WHERE topic_id IN (",
        topics, ") ORDER BY rowid");
    const std::scoped_lock lock(mutex_);
    return database_.for_each_row(select, [&](const SqliteRow& row) -> Result<void> {
      const auto id = row.integer(0);
      const auto topic = row.integer(1);
      const auto time_ns = row.integer(2);
      const auto bytes = row.bytes(3);
      const auto channel = channel_of_topic_.find(topic.value_or(0));
      if (!id || !topic || !time_ns || !bytes || channel == channel_of_topic_.end()) {
        return database_.damaged(concat("found no time or no bytes of message ", id.value_or(0)));
      }
      const MessagePlace place{0, 0, static_cast<std::uint64_t>(*id), bytes->size()};
      return body({channel->second, *time_ns, place, *bytes});
    });
  }

  Result<std::vector<std::byte>> read(const MessagePlace& place) const override {
    const std::string id = std::to_string(static_cast<std::int64_t>(place.offset));
    std::vector<std::byte> message;
    bool is_there = false;
    const std::scoped_lock lock(mutex_);
    SIGHTLINE_TRY(database_.for_each_row("SELECT data FROM messages WHERE rowid = " + id,
                                         [&](const SqliteRow& row) -> Result<void> {
                                           const auto bytes = row.bytes(0);
                                           is_there = bytes && bytes->size() == place.size;
                                           if (is_there)
                                             message.assign(bytes->begin(), bytes->end());
                                           return {};
                                         }));
    if (is_there) return message;
    return database_.damaged(
        concat("found message ", id, " in the table, but cannot find it again"));
  }

 private:
  Result<void> add_topics() {
    for (const char* table : {"topics", "messages"}) {
      SIGHTLINE_ASSIGN(const bool is_there, database_.has_table(table));
      if (is_there) continue;
      return Error{
          ErrorCode::kUnsupportedFormat,
          concat("a database without a table '", table, "', expected a recording of ros2 bag"),
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
            return database_.damaged(
                "found a topic without number, name, type or format, or twice");
          }
          // Tools that rewrite recordings leave it out; ros2 bag itself writes nothing but CDR.
          const std::string_view encoding = format->empty() ? "cdr" : std::string_view(*format);
          channels_[number] = {std::string(*name), ros1_type_name(*type), encoding_named(encoding),
                               0};
          return {};
        });
  }

  Result<void> count_messages() {
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
            return database_.damaged(concat("found message ", *id, " of a topic that is missing"));
          }
          ++channels_[found->second].message_count;
          return {};
        });
  }

  SqliteFile database_;
  std::map<std::int64_t, std::uint32_t> channel_of_topic_;  // by the database's number
  mutable std::mutex mutex_;                                // of the database
};

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
