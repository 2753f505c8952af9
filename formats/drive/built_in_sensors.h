#pragma once

#include <vector>

#include "formats/drive/sensor_profile.h"

namespace sightline {

// All that sensor_profile() knows. Of profiles with the same beams the last is recognized
// (guess_sensor).
std::vector<SensorProfile> built_in_sensors();

}  // namespace sightline
