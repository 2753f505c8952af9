#pragma once

#include <filesystem>
#include <memory>

#include "formats/foreign/ros/files/message_log.h"

namespace sightline {

// Opens a ROS 1 bag of format 2.0 (chunks as they are, or packed by bz2 or lz4). A chunk that holds
// no wanted message by the bag's index is passed over. Where there is no index, since the bag was
// not closed, the chunks are read in turn. The most memory is the index and one chunk, packed and
// unpacked (most_unpacked). Errors: those of MessageLog, with the byte; cannot-open.
// unsupported-format: another version, an unknown compression, an encrypted bag.
Result<std::unique_ptr<MessageLog>> open_ros1_bag(const std::filesystem::path& path);

}  // namespace sightline
