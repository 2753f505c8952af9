#pragma once

#include <filesystem>
#include <memory>

#include "formats/foreign/ros/files/message_log.h"

namespace sightline {

// Whether a file begins like MCAP.
bool is_mcap(const std::filesystem::path& path);

// Opens an MCAP file with messages of ROS 1 or ROS 2, with chunks (as they are, lz4, zstd) or
// without, with an index or without. A chunk that holds no wanted message by what stands behind it
// is passed over; where nothing does, chunks are unpacked once more. The most memory is the index
// and one chunk, packed and unpacked (most_unpacked). A chunk's checksum is verified where it has
// one. A file that was not closed, or holds other messages than
// its summary counts, gives a warning. Errors: those of MessageLog, with the byte;
// cannot-open.
Result<std::unique_ptr<MessageLog>> open_mcap(const std::filesystem::path& path);

}  // namespace sightline
