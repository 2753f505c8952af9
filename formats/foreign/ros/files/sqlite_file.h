#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace sightline {

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
    void operator()(sqlite3* database) const;
  };
  SqliteFile(std::filesystem::path path, std::uint64_t size)
      : path_(std::move(path)), size_(size) {}
  Result<void> connect();
  [[nodiscard]] Error error_of(int status) const;

  std::filesystem::path path_;
  std::uint64_t size_ = 0;  // of the file, bytes
  std::unique_ptr<sqlite3, Closer> database_;
};

}  // namespace sightline
