#include "transforms.h"

#include <chrono>

#include "messages.h"

namespace sightline_ros2 {

std::optional<PoseRows> Transforms::find(const std::string& target, const std::string& source,
                                         std::int64_t stamp_ns, std::string& fault) {
  if (target == source) return rows_of(Pose());
  try {
    const tf2::TimePoint time{std::chrono::nanoseconds(stamp_ns)};
    const tf2::Duration wait = std::chrono::milliseconds(stamp_ns == 0 ? 0 : 50);
    return rows_of(buffer_.lookupTransform(target, source, time, wait).transform);
  } catch (const tf2::TransformException& failure) {
    fault = "No transform from '" + source + "' to '" + target + "': " + failure.what();
    return std::nullopt;
  }
}

void Transforms::send(std::int64_t stamp_ns, const std::string& parent, const std::string& child,
                      const Pose& pose) {
  broadcaster_.sendTransform(transform_of(stamp_ns, parent, child, pose));
}

}  // namespace sightline_ros2
