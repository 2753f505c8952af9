#pragma once

#include <vector>

#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/record/fields.h"

namespace sightline {

// Where the scans of a map were when it was shipped, so that the next one, made of these drives and
// of more, moves nothing of it. A file of its own beside the map (.slposes).
struct ReleasedPoses {
  Trajectory trajectory;
  std::vector<Digest> scans;  // of each pose: which scan (ScanStore::identity)
};
SIGHTLINE_FIELDS(ReleasedPoses, trajectory, scans)

template <>
struct ArtifactTraits<ReleasedPoses> {
  static constexpr std::string_view kName = "released-poses";
  static constexpr std::uint32_t kVersion = 1;
};

// The poses of a drive to be shipped. Error: invalid-artifact (scans that have no identity).
Result<ReleasedPoses> release(const Drive& drive, const Trajectory& trajectory);

// Which pose each scan of a drive has; nullptr where none was released. Refers to `released`.
std::vector<const TrajectoryPose*> poses_of(const Drive& drive, const ReleasedPoses& released);

Result<void> validate(const ReleasedPoses& released);
Table dump(const ReleasedPoses& released);

}  // namespace sightline
