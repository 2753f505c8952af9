#include "formats/foreign/ros/bag_topics.h"

#include <algorithm>
#include <utility>

#include "formats/base/units.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Some publishers compute a fixed transform anew each time; what moves changes by more.
bool is_same(const Pose& a, const Pose& b) {
  constexpr double kSamePlace_m = 1e-4;
  constexpr double kSameRotation = 1e-5;
  return (a.translation() - b.translation()).norm() < kSamePlace_m &&
         (a.linear() - b.linear()).norm() < kSameRotation;
}

Error error_of(const fs::path& path, ErrorCode code, std::string message) {
  return {code, std::move(message), path.string()};
}

}  // namespace

TopicChoice topics_of(const MessageLog& log, TypeTest is_type) {
  TopicChoice choice;
  for (const auto& [number, channel] : log.channels()) {
    if (channel.message_count == 0) continue;
    if (channel.encoding && is_type(channel.type)) choice.fitting.insert(channel.topic);
    choice.all += concat(" ", channel.topic, " (", channel.type,
                         (channel.encoding ? ")" : ", neither in CDR nor in the form of ROS 1)"));
  }
  return choice;
}

Result<std::string> choose_topic(const fs::path& path, const TopicChoice& topics,
                                 const std::string& wanted) {
  if (topics.fitting.contains(wanted)) return wanted;
  if (!wanted.empty()) {
    return error_of(
        path, ErrorCode::kUnknownName,
        concat("no topic '", wanted, "' of a supported type; the bag has:", topics.all));
  }
  if (topics.fitting.size() == 1) return *topics.fitting.begin();
  if (topics.fitting.empty()) {
    return error_of(
        path, ErrorCode::kUnsupportedFormat,
        concat("no topic of a supported type; the bag has:", topics.all,
               ". Play it to the sensor's driver and record the resulting sensor_msgs/PointCloud2 "
               "(packets and single lines of a scan are not read)"));
  }
  return error_of(path, ErrorCode::kBadValue,
                  "several topics are possible, name one of them; the bag has:" + topics.all);
}

std::set<std::uint32_t> channels_of(const MessageLog& log, const std::string& topic,
                                    TypeTest is_type) {
  std::set<std::uint32_t> numbers;
  for (const auto& [number, channel] : log.channels()) {
    const bool is_wanted = topic.empty() || channel.topic == topic;
    if (is_wanted && channel.encoding && is_type(channel.type)) numbers.insert(number);
  }
  return numbers;
}

Result<TransformTree> read_transforms(const fs::path& path, const MessageLog& log) {
  TransformTree tree;
  SIGHTLINE_TRY(log.for_each_message(
      channels_of(log, "", &is_transforms_message),
      [&](const LoggedMessage& message) -> Result<void> {
        const LogChannel& channel = log.channels().at(message.channel);
        SIGHTLINE_ASSIGN(const std::vector<StampedTransform> transforms,
                         parse_transforms(message.bytes, path.string(), *channel.encoding));
        const bool is_static = channel.topic.ends_with("tf_static");
        for (const StampedTransform& transform : transforms) tree.add(transform, is_static);
        return {};
      }));
  return tree;
}

void TransformTree::add(const StampedTransform& transform, bool is_static) {
  Edge& edge = edges_[transform.child];
  if (edge.poses.empty()) edge.parent = transform.parent;
  if (edge.parent != transform.parent) edge.other_parent = transform.parent;
  edge.is_static = edge.is_static || is_static;
  if (edge.is_static) edge.poses.clear();
  edge.poses.emplace(transform.stamp_ns, transform.T_parent_child);
  const bool is_other = !is_same(transform.T_parent_child, edge.poses.begin()->second);
  edge.moves = !edge.is_static && (edge.moves || is_other);
}

std::string TransformTree::frames() const {
  std::string names;
  for (const auto& [child, edge] : edges_) names += " " + child;
  return names;
}

// T_parent_child; one that does not move holds at all times.
std::optional<Pose> TransformTree::pose_at(const Edge& edge, std::int64_t stamp_ns) {
  constexpr std::int64_t kLongestGap_ns = 2 * kSecond_ns;  // localizers correct once a second
  if (!edge.moves) return edge.poses.begin()->second;
  const auto after = edge.poses.lower_bound(stamp_ns);
  if (after != edge.poses.end() && after->first == stamp_ns) return after->second;
  if (after == edge.poses.begin() || after == edge.poses.end()) return std::nullopt;
  const auto before = std::prev(after);
  const std::int64_t gap_ns = after->first - before->first;
  if (gap_ns > kLongestGap_ns) return std::nullopt;
  return interpolate(before->second, after->second,
                     static_cast<double>(stamp_ns - before->first) / static_cast<double>(gap_ns));
}

Error TransformTree::error(ErrorCode code, const std::string& message,
                           const std::string& file) const {
  return {code, concat(message, "; frames with a parent:", frames()), file};
}

// From the frame upwards.
Result<std::vector<const TransformTree::Edge*>> TransformTree::chain_above(
    const std::string& frame, const std::string& file) const {
  std::vector<const Edge*> chain;
  std::string top = frame;
  for (auto at = edges_.find(frame); at != edges_.end() && top != "map"; at = edges_.find(top)) {
    const Edge& edge = at->second;
    if (chain.size() == edges_.size()) {
      return error(ErrorCode::kMalformedPose, concat("frame ", top, " is its own parent"), file);
    }
    if (!edge.other_parent.empty()) {
      return error(
          ErrorCode::kMalformedPose,
          concat("frame ", top, " has two parents, ", edge.parent, " and ", edge.other_parent),
          file);
    }
    chain.push_back(&edge);
    top = edge.parent;
  }
  return chain;
}

Result<std::vector<PoseRow>> TransformTree::poses_of(const std::string& frame,
                                                     const std::string& file) const {
  SIGHTLINE_ASSIGN(const std::vector<const Edge*> chain, chain_above(frame, file));
  const auto fastest = std::ranges::max_element(
      chain, {}, [](const Edge* edge) { return edge->moves ? edge->poses.size() : 0; });
  if (fastest == chain.end() || !(*fastest)->moves) {
    return error(ErrorCode::kNoPoses, concat("no moving transform is above frame '", frame, "'"),
                 file);
  }
  std::vector<PoseRow> rows;
  for (const auto& [stamp_ns, unused] : (*fastest)->poses) {
    PoseRow row;
    row.stamp_ns = stamp_ns;
    bool is_known = true;
    for (const Edge* edge : chain) {
      const std::optional<Pose> T_parent_child = pose_at(*edge, stamp_ns);
      is_known = is_known && T_parent_child;
      if (is_known) row.T_world_vehicle = *T_parent_child * row.T_world_vehicle;
    }
    if (is_known) rows.push_back(row);
  }
  if (!rows.empty()) return rows;
  return error(ErrorCode::kNoPoses,
               concat("the moving transforms above frame '", frame, "' have no time in common"),
               file);
}

std::string TransformTree::frame_above(const std::string& frame) const {
  const Result<std::vector<const Edge*>> chain = chain_above(frame, "");
  return chain && !chain->empty() ? chain->back()->parent : frame;
}

std::optional<Pose> TransformTree::fixed_pose(const std::string& ancestor,
                                              const std::string& frame) const {
  Pose T_top_frame = Pose::Identity();
  std::string top = frame;
  for (std::size_t steps = 0; steps <= edges_.size(); ++steps) {
    if (top == ancestor) return T_top_frame;
    const auto at = edges_.find(top);
    if (at == edges_.end() || at->second.moves) return std::nullopt;
    T_top_frame = at->second.poses.begin()->second * T_top_frame;
    top = at->second.parent;
  }
  return std::nullopt;
}

std::map<std::string, Pose> TransformTree::fixed_ancestors(const std::string& frame) const {
  std::map<std::string, Pose> ancestors;
  Pose T_top_frame = Pose::Identity();
  std::string top = frame;
  while (ancestors.emplace(top, T_top_frame).second) {  // else frames lie in a circle
    const auto at = edges_.find(top);
    const bool is_fixed =
        at != edges_.end() && at->second.other_parent.empty() && !at->second.moves;
    if (!is_fixed) break;
    T_top_frame = at->second.poses.begin()->second * T_top_frame;
    top = at->second.parent;
  }
  return ancestors;
}

std::optional<Pose> TransformTree::fixed_between(const std::string& to,
                                                 const std::string& from) const {
  const std::map<std::string, Pose> above_to = fixed_ancestors(to);
  for (const auto& [ancestor, T_ancestor_from] : fixed_ancestors(from)) {
    const auto common = above_to.find(ancestor);
    if (common != above_to.end()) return common->second.inverse() * T_ancestor_from;
  }
  return std::nullopt;
}

}  // namespace sightline
