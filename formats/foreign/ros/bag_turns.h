#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"

namespace sightline {

// How fast the sensor of a bag's scans turned, as an inertial unit beside it measured.
struct BagTurns {
  std::string topic;                  // whose they are; empty: there are none
  std::vector<TurnRate> of_sensor;    // about the axes of the sensor's frame; ascending in time
  std::vector<std::string> warnings;  // which topic it is, what is left out, and why
};

// The angular velocities of one topic of sensor_msgs/Imu: of the one named, or, where the name is
// empty, of the only one. Of several the one is taken whose frame is known in that of the scans,
// and of those the one with the most messages. A frame is known where it is the scans' own, or
// where transforms that do not move lead from one to the other; else nothing is taken and a warning
// says so. Messages are put in order of their stamps (of the time of their recording where the
// driver left them at zero); of two at one time the first recorded counts. Messages that are short,
// not finite, say that there is no angular velocity or turn faster than 100 rad/s are counted in a
// warning. Nothing, without a warning, where no topic is of that type and none is named. Errors:
// unknown-name (the named one is not there), and where one is named those of open_message_log and
// parse_transforms; else these are a warning.
Result<BagTurns> read_bag_turns(const std::filesystem::path& path, const std::string& topic,
                                const std::string& sensor_frame);

}  // namespace sightline
