#include "formats/foreign/ros/files/sqlite_vfs.h"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

#include "formats/foreign/logs/random_access_file.h"

// SQLite calls these functions instead of the operating system. Its own would follow a pipe, lock
// the file and make files beside it, which a recording on read-only storage does not allow. The
// file is opened as immutable, so neither locks nor journals are used.

namespace sightline {
namespace {

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

}  // namespace

const char* read_only_vfs() {
  static sqlite3_vfs vfs = made_vfs();
  static const int kRegistered = sqlite3_vfs_register(&vfs, /*makeDflt=*/0);
  return kRegistered == SQLITE_OK ? vfs.zName : nullptr;
}

}  // namespace sightline
