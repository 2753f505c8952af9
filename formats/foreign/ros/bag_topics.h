#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/ros/files/message_log.h"
#include "formats/foreign/ros/transform_tree.h"

// The topics of an opened bag, and its transforms; part of ros_bag and bag_turns.

namespace sightline {

using TypeTest = bool (*)(std::string_view type);

struct TopicChoice {
  std::set<std::string> fitting;  // of a type that is wanted
  std::string all;                // for messages
};

// Topics without messages count for nothing.
TopicChoice topics_of(const MessageLog& log, TypeTest is_type);

// The topic to read: the one that is named, or the only one of a type that is wanted. Errors:
// unknown-name, unsupported-format (there is none), bad-value (several).
Result<std::string> choose_topic(const std::filesystem::path& path, const TopicChoice& topics,
                                 const std::string& wanted);

// The channels of a topic (empty: of all) with messages of such a type.
std::set<std::uint32_t> channels_of(const MessageLog& log, const std::string& topic,
                                    TypeTest is_type);

// All of /tf and /tf_static. Errors: those of parse_transforms and of the log.
Result<TransformTree> read_transforms(const std::filesystem::path& path, const MessageLog& log);

}  // namespace sightline
