#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/release/records.h"

// What a vehicle checks before it drives with a new map, in the order of
// schemas/release_format.md. Nothing here touches the network, and time comes from the caller.

namespace sightline {

// Enough distinct keys of the root signed these bytes. Signatures by keys that the root does not
// know are skipped. Errors: malformed-signature; bad-signature (by a key of the root, but of other
// bytes); wrong-key (none by a key of the root), too-few-signatures.
Result<void> check_signatures(std::string_view message, std::string_view signatures,
                              const RootRecord& root);

// The root that follows `trusted`: of the same fleet, the next version, signed by the threshold of
// the old root's keys and by that of its own. Whether it has expired is asked only of the last one
// of a chain. Errors: those of check_signatures and decode_root_record; wrong-fleet,
// root-out-of-order.
Result<RootRecord> next_root(const RootRecord& trusted, std::string_view text,
                             std::string_view signatures);

// A vehicle's side of the matter.
struct VehicleFacts {
  std::int64_t now_s = 0;             // UTC, since 1970
  SeenState seen;                     // what it remembers; without a release: nothing yet
  std::optional<Digest> sensor;       // sensor_digest() of its LiDAR; none: any
  std::optional<std::string> map_id;  // the map it wants; none: that of the seen one, or any
};

// Whether the root has too few keys that this vehicle has ever admitted a release under, for those
// to reach the threshold: then nothing that was signed before is valid any more, and what the
// vehicle has seen does not count (recovery from fast-forward, as TUF 5.3.11).
bool begins_anew(const RootRecord& root, const SeenState& seen);

// A release signed under `root` that this vehicle may install. Errors: expired (the root's too);
// those of check_signatures and decode_release_record; wrong-fleet (or map id), replayed-release,
// future-version, wrong-sensor.
Result<ReleaseRecord> admit_release(std::string_view text, std::string_view signatures,
                                    const RootRecord& root, const VehicleFacts& vehicle);

// The same, and what the vehicle has to remember from here on, whatever came of it: also a refused
// release shows that it is later than its expiry.
struct Admission {
  Result<ReleaseRecord> record;
  SeenState seen;
};
Admission admit_and_remember(std::string_view text, std::string_view signatures,
                             const RootRecord& root, const VehicleFacts& vehicle);

// That a file arrived as it was released. Errors: file-not-found, cannot-open, cannot-read;
// longer-than-released, not-as-released.
Result<void> check_file(const std::filesystem::path& path, const ReleasedFile& released);

// The same of the map, and that every digest, bound and order in it holds and its manifest is the
// one released. Errors: also those of verify_map().
Result<void> check_map(const std::filesystem::path& path, const ReleaseRecord& record);

// What to fetch for a vehicle that has a map, or none ("").
struct FetchPlan {
  enum class Kind { kNothing, kDelta, kMap };
  Kind kind = Kind::kMap;
  ReleasedFile file;
};
// The map it has is the released one: nothing; the base of a delta: that; otherwise the whole map.
FetchPlan plan_fetch(const std::filesystem::path& present_map, const ReleaseRecord& record);

// "nothing", "delta NAME SIZE SHA256", "map NAME SIZE SHA256"
std::string to_text(const FetchPlan& plan);

}  // namespace sightline
