#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/ros/ros_messages.h"

// The topics of an opened bag, and its transforms; part of ros_bag and bag_turns.

namespace sightline {

// The frames of a recording (/tf and /tf_static), each within its parent, over time.
class TransformTree {
 public:
  // A static one holds at all times; of several the last counts.
  void add(const StampedTransform& transform, bool is_static);

  [[nodiscard]] bool has_frame(const std::string& frame) const { return edges_.contains(frame); }
  // All frames that have a parent, for messages.
  [[nodiscard]] std::string frames() const;

  // Where `frame` was: its poses in "map" where that is above it, else in the topmost frame above
  // it, at the times of the fastest of the moving transforms between both; others are interpolated
  // there. Times at which one of them is not known within 2 s are left out. Errors: no-poses (no
  // such frame, or nothing moves above it), malformed-pose (two parents, or a circle).
  [[nodiscard]] Result<std::vector<PoseRow>> poses_of(const std::string& frame,
                                                      const std::string& file) const;
  // The frame that these poses are in; the frame itself where there is none above it.
  [[nodiscard]] std::string frame_above(const std::string& frame) const;
  // T_ancestor_frame by transforms that do not move; nothing where there is no such chain.
  [[nodiscard]] std::optional<Pose> fixed_pose(const std::string& ancestor,
                                               const std::string& frame) const;
  // T_to_from of two frames of one rigid body, by transforms that are the same whenever they are
  // said; nothing where there is no such way, or a frame on it has two parents.
  [[nodiscard]] std::optional<Pose> fixed_between(const std::string& to,
                                                  const std::string& from) const;

 private:
  struct Edge {
    std::string parent;
    std::string other_parent;  // empty: only one was named
    bool is_static = false;
    bool moves = false;  // not where it is the same each time, as ROS 1 repeats fixed transforms
    std::map<std::int64_t, Pose> poses;  // T_parent_child by time; a static one has one
  };
  [[nodiscard]] Error error(ErrorCode code, const std::string& message,
                            const std::string& file) const;
  [[nodiscard]] Result<std::vector<const Edge*>> chain_above(const std::string& frame,
                                                             const std::string& file) const;
  // T_ancestor_frame for the frame and all that is fixed above it.
  [[nodiscard]] std::map<std::string, Pose> fixed_ancestors(const std::string& frame) const;
  static std::optional<Pose> pose_at(const Edge& edge, std::int64_t stamp_ns);

  std::map<std::string, Edge> edges_;  // by child
};

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
