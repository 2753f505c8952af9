#include "formats/foreign/ros/files/sqlite_file.h"

#include <sqlite3.h>
#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>

#include "formats/foreign/logs/random_access_file.h"

namespace sightline {
namespace {

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
  return file.error_at(file.size(),
                       "found " + std::to_string(file.size()) + " bytes of a database, expected " +
                           std::to_string(pages * page_size),
                       ErrorCode::kTruncatedScan);
}

Result<void> check_was_closed(const std::filesystem::path& path) {
  for (const char* ending : {"-wal", "-journal"}) {
    std::error_code failure;
    const std::filesystem::path beside = path.string() + ending;
    const std::uintmax_t size = std::filesystem::file_size(beside, failure);
    if (failure || size == 0) continue;
    return Error{ErrorCode::kMalformedHeader,
                 "the recording was not closed, a part of it lies in " +
                     beside.filename().string() + "; `sqlite3 " + path.filename().string() +
                     " 'PRAGMA journal_mode=DELETE'` brings both together",
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

int refuse_write(sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; }
int refuse_truncate(sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; }
int do_nothing(sqlite3_file*, int) { return SQLITE_OK; }
int is_reserved(sqlite3_file*, int* answer) {
  *answer = 0;
  return SQLITE_OK;
}
int control(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int sector_size(sqlite3_file*) { return 4096; }
int characteristics(sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; }

const sqlite3_io_methods& methods() {
  static const sqlite3_io_methods kMethods = [] {
    sqlite3_io_methods made{};
    made.iVersion = 1;
    made.xClose = close_file;
    made.xRead = read_file;
    made.xWrite = refuse_write;
    made.xTruncate = refuse_truncate;
    made.xSync = do_nothing;
    made.xFileSize = file_size;
    made.xLock = do_nothing;
    made.xUnlock = do_nothing;
    made.xCheckReservedLock = is_reserved;
    made.xFileControl = control;
    made.xSectorSize = sector_size;
    made.xDeviceCharacteristics = characteristics;
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

int refuse_delete(sqlite3_vfs*, const char*, int) { return SQLITE_READONLY; }
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
int no_sleep(sqlite3_vfs*, int) { return 0; }
int no_time(sqlite3_vfs*, double* days) {
  *days = 0.0;
  return SQLITE_OK;
}
int no_error(sqlite3_vfs*, int, char*) { return 0; }

sqlite3_vfs made_vfs() {
  constexpr int kLongestPath = 4096;
  sqlite3_vfs made{};
  made.iVersion = 1;
  made.szOsFile = sizeof(OpenFile);
  made.mxPathname = kLongestPath;
  made.zName = "sightline-read-only";
  made.xOpen = open_file;
  made.xDelete = refuse_delete;
  made.xAccess = nothing_is_there;
  made.xFullPathname = full_name;
  made.xRandomness = no_randomness;
  made.xSleep = no_sleep;
  made.xCurrentTime = no_time;
  made.xGetLastError = no_error;
  return made;
}

// The name of a file system for SQLite in which regular files are read and nothing else is done;
// registered at the first call.
const char* read_only_vfs() {
  static sqlite3_vfs vfs = made_vfs();
  static const int kRegistered = sqlite3_vfs_register(&vfs, /*makeDflt=*/0);
  return kRegistered == SQLITE_OK ? vfs.zName : nullptr;
}

}  // namespace

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

void SqliteFile::Closer::operator()(sqlite3* database) const { sqlite3_close(database); }

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

}  // namespace sightline
