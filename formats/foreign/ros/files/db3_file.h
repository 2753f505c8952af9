#pragma once

#include <filesystem>
#include <memory>

#include "formats/foreign/ros/files/message_log.h"

namespace sightline {

// Whether a file begins like a database of SQLite that names no application of its own: a .db3 of
// rosbag2.
bool is_db3(const std::filesystem::path& path);

// Opens a .db3 as rosbag2 writes it, read-only. Errors: those of MessageLog and SqliteFile;
// unsupported-format (a database without topics and messages).
Result<std::unique_ptr<MessageLog>> open_db3(const std::filesystem::path& path);

}  // namespace sightline
