#include "passes/localize/match_contents.h"

#include <utility>
#include <vector>

#include "passes/matching/localizer.h"

namespace sightline {
namespace {

// A match may start where another one ended; and more than the cells around a point, the start and
// the mounting.
constexpr double kStray_m = 2.0 * kFarthestFound_m + 16.0;

}  // namespace

MatchContents::MatchContents(const Drive& drive, const Trajectory& trajectory, TileDigests nds,
                             double longest_m)
    : drive_(drive), trajectory_(trajectory), longest_m_(longest_m), nds_(std::move(nds)) {}

std::optional<Digest> MatchContents::of(std::span<const std::optional<std::size_t>> scans) const {
  ByteWriter writer;
  encode(drive_.sensor, writer);
  std::vector<Eigen::Vector3d> places_m;
  for (const std::optional<std::size_t>& scan : scans) {
    if (!scan) continue;
    const std::optional<Digest> identity = drive_.store->identity(*scan);
    if (!identity) return std::nullopt;
    const Pose& T_map_vehicle = trajectory_.poses[*scan].T_map_vehicle;
    writer.put(drive_.scans[*scan].recording_index);  // its seed
    writer.put_array(std::span<const std::uint8_t>(*identity));
    encode(T_map_vehicle, writer);
    places_m.push_back(T_map_vehicle.translation());
  }
  DigestBuilder builder;
  builder.add(writer.bytes());
  if (!places_m.empty()) {
    builder.add(nds_.within(box_around(places_m, longest_m_ + kStray_m)));
  }
  return builder.finish();
}

}  // namespace sightline
