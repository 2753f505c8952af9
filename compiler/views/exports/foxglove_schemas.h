#pragma once

#include <nlohmann/json.hpp>

namespace sightline {

// JSON schemas of the messages that foxglove_mcap() writes. Names, members and types are those of
// Foxglove's own message schemas (docs.foxglove.dev/docs/sdk/schemas), as far as they are written:
// what Foxglove validates there is valid here too, and the other way round.
nlohmann::ordered_json foxglove_point_cloud_schema();
nlohmann::ordered_json foxglove_scene_update_schema();
nlohmann::ordered_json foxglove_poses_in_frame_schema();
nlohmann::ordered_json foxglove_pose_in_frame_schema();
nlohmann::ordered_json foxglove_frame_transform_schema();
nlohmann::ordered_json foxglove_location_fix_schema();

}  // namespace sightline
