#include "formats/release/admission.h"

#include <algorithm>
#include <vector>

#include "formats/map/map_reader.h"
#include "formats/reader/map_layout.h"
#include "formats/reader/mapped_file.h"
#include "formats/release/record_text.h"
#include "formats/release/signatures.h"

namespace sightline {
namespace {

// Which of the root's keys signed; the same key twice is one.
Result<std::vector<bool>> signers_of(std::string_view message, std::string_view signatures,
                                     const RootRecord& root) {
  SIGHTLINE_ASSIGN(const std::vector<Signature> parsed, parse_signatures(signatures));
  std::vector<bool> has_signed(root.keys.size(), false);
  for (const Signature& signature : parsed) {
    for (std::size_t k = 0; k < root.keys.size(); ++k) {
      if (root.keys[k].id != signature.key_id) continue;
      if (!is_valid(signature, message, root.keys[k])) {
        return Error{ErrorCode::kBadSignature,
                     concat("the signature by key ", to_hex(signature.key_id),
                            " does not match this record")};
      }
      has_signed[k] = true;
    }
  }
  return has_signed;
}

Error expired(const std::string& what, std::int64_t expires_s, std::int64_t now_s) {
  return {ErrorCode::kExpired,
          concat(what, " expired at ", utc_text(expires_s), ", now it is ", utc_text(now_s))};
}

Result<void> check_counter(std::string_view text, const ReleaseRecord& record,
                           const ReleaseRecord& seen, std::string_view seen_text) {
  if (record.counter > seen.counter || text == seen_text) return {};
  return Error{ErrorCode::kReplayedRelease,
               concat("found counter ", record.counter, ", this vehicle has already accepted ",
                      seen.counter)};
}

Result<void> check_identity(std::string_view text, const ReleaseRecord& record,
                            const RootRecord& root, const VehicleFacts& vehicle) {
  if (record.fleet != root.fleet) {
    return Error{ErrorCode::kWrongFleet,
                 concat("found a release of fleet ", record.fleet, ", expected ", root.fleet)};
  }
  std::optional<std::string> map_id = vehicle.map_id;
  if (!vehicle.seen.release.empty() && !begins_anew(root, vehicle.seen)) {
    SIGHTLINE_ASSIGN(const ReleaseRecord seen, decode_release_record(vehicle.seen.release));
    SIGHTLINE_TRY(check_counter(text, record, seen, vehicle.seen.release));
    if (!map_id) map_id = seen.map_id;
  }
  if (map_id && record.map_id != *map_id) {
    return Error{ErrorCode::kWrongFleet,
                 concat("found a release of map ", record.map_id, ", expected ", *map_id)};
  }
  return {};
}

Result<void> check_fit(const ReleaseRecord& record, const VehicleFacts& vehicle) {
  const auto needed = std::pair(record.minimum_major, record.minimum_minor);
  if (needed >
      std::pair(std::uint32_t{kFormatVersion.major}, std::uint32_t{kFormatVersion.minor})) {
    return Error{ErrorCode::kFutureVersion,
                 concat("the release needs a reader of format ", needed.first, ".", needed.second)};
  }
  if (vehicle.sensor && record.sensor != *vehicle.sensor) {
    return Error{ErrorCode::kWrongSensor,
                 concat("the release is for sensor ", to_hex(record.sensor), ", this vehicle has ",
                        to_hex(*vehicle.sensor))};
  }
  return {};
}

Error not_as_released(const std::string& what, const std::string& found,
                      const std::string& expected) {
  return {ErrorCode::kNotAsReleased, concat(what, " is ", found, ", the release has ", expected)};
}

// The manifest that a map carries against the record that names the map.
Result<void> check_facts(const ReleaseRecord& map, const ReleaseRecord& record) {
  const std::string facts[][3] = {
      {"map id", map.map_id, record.map_id},
      {"version", map.version, record.version},
      {"map release", std::to_string(map.map_release), std::to_string(record.map_release)},
      {"root digest", to_hex(map.root_digest), to_hex(record.root_digest)},
      {"sensor", to_hex(map.sensor), to_hex(record.sensor)}};
  for (const auto& [what, found, expected] : facts) {
    if (found != expected) return not_as_released(what, found, expected);
  }
  return {};
}

// By the vehicle's clock, which may have stopped or jumped back.
std::int64_t latest_s(const RootRecord& root, const VehicleFacts& vehicle) {
  return begins_anew(root, vehicle.seen) ? vehicle.now_s
                                         : std::max(vehicle.now_s, vehicle.seen.time_s);
}

// All checks up to the release's expiry.
Result<ReleaseRecord> check_record(std::string_view text, std::string_view signatures,
                                   const RootRecord& root, const VehicleFacts& vehicle) {
  const std::int64_t now_s = latest_s(root, vehicle);
  if (now_s >= root.expires_s) return expired("the root", root.expires_s, now_s);
  SIGHTLINE_TRY(check_signatures(text, signatures, root));
  SIGHTLINE_ASSIGN(ReleaseRecord record, decode_release_record(text));
  SIGHTLINE_TRY(check_identity(text, record, root, vehicle));
  return record;
}

}  // namespace

bool begins_anew(const RootRecord& root, const SeenState& seen) {
  // Without keys nothing is known of the root that the release was admitted under.
  if (seen.keys.empty() || seen.keys.size() >= kMostSeenKeys) return false;
  const auto is_known = [&](const PublicKey& key) {
    return std::any_of(seen.keys.begin(), seen.keys.end(),
                       [&](const PublicKey& old) { return old.point == key.point; });
  };
  const auto known = std::count_if(root.keys.begin(), root.keys.end(), is_known);
  return static_cast<std::uint32_t>(known) < root.threshold;
}

Result<void> check_signatures(std::string_view message, std::string_view signatures,
                              const RootRecord& root) {
  SIGHTLINE_ASSIGN(const std::vector<bool> signers, signers_of(message, signatures, root));
  const auto count = std::count(signers.begin(), signers.end(), true);
  if (count >= root.threshold) return {};
  return Error{count == 0 ? ErrorCode::kWrongKey : ErrorCode::kTooFewSignatures,
               concat("found signatures by ", count, " keys of root ", root.version, ", expected ",
                      root.threshold)};
}

Result<RootRecord> next_root(const RootRecord& trusted, std::string_view text,
                             std::string_view signatures) {
  SIGHTLINE_TRY(check_signatures(text, signatures, trusted));
  SIGHTLINE_ASSIGN(RootRecord next, decode_root_record(text));
  SIGHTLINE_TRY(check_signatures(text, signatures, next));
  if (next.fleet != trusted.fleet) {
    return Error{ErrorCode::kWrongFleet,
                 concat("found a root of fleet ", next.fleet, ", expected ", trusted.fleet)};
  }
  if (next.version != trusted.version + 1) {
    return Error{ErrorCode::kRootOutOfOrder,
                 concat("found root ", next.version, ", expected ", trusted.version + 1)};
  }
  return next;
}

Result<ReleaseRecord> admit_release(std::string_view text, std::string_view signatures,
                                    const RootRecord& root, const VehicleFacts& vehicle) {
  return admit_and_remember(text, signatures, root, vehicle).record;
}

Admission admit_and_remember(std::string_view text, std::string_view signatures,
                             const RootRecord& root, const VehicleFacts& vehicle) {
  SeenState seen = vehicle.seen;
  Result<ReleaseRecord> record = check_record(text, signatures, root, vehicle);
  if (!record) return {record, seen};
  const std::int64_t now_s = latest_s(root, vehicle);
  if (now_s >= record->expires_s) {
    // No later than that: a clock that jumps ahead for once must not end all releases to come.
    seen.time_s = std::max(seen.time_s, record->expires_s);
    return {expired("the release", record->expires_s, now_s), seen};
  }
  const Result<void> fit = check_fit(*record, vehicle);
  if (!fit) return {fit.error(), seen};
  seen.time_s = now_s;
  seen.release = text;
  add_keys(root.keys, seen);
  return {record, seen};
}

Result<void> check_file(const std::filesystem::path& path, const ReleasedFile& released) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(path.string()));
  const std::uint64_t size = file.bytes().size();
  if (size > released.size) {
    return Error{ErrorCode::kLongerThanReleased,
                 concat("found ", size, " bytes, the release has ", released.size), path.string(),
                 concat("byte ", released.size)};
  }
  if (size < released.size) {
    return in_file(not_as_released("the size", std::to_string(size), std::to_string(released.size)),
                   path.string());
  }
  const Digest digest = sha256(file.bytes());
  if (digest != released.sha256) {
    return in_file(not_as_released("the SHA-256", to_hex(digest), to_hex(released.sha256)),
                   path.string());
  }
  return {};
}

Result<void> check_map(const std::filesystem::path& path, const ReleaseRecord& record) {
  SIGHTLINE_TRY(check_file(path, record.map));
  SIGHTLINE_TRY(verify_map(path));
  SIGHTLINE_ASSIGN(const ReleaseRecord map, release_of_map(path));
  const Result<void> facts = check_facts(map, record);
  if (!facts) return in_file(facts.error(), path.string());
  return {};
}

FetchPlan plan_fetch(const std::filesystem::path& present_map, const ReleaseRecord& record) {
  if (!present_map.empty()) {
    const Result<MappedFile> present = MappedFile::open(present_map.string());
    if (present) {
      const Digest digest = sha256(present->bytes());
      if (digest == record.map.sha256) return {FetchPlan::Kind::kNothing, {}};
      for (const ReleasedDelta& delta : record.deltas) {
        if (delta.base_sha256 == digest) return {FetchPlan::Kind::kDelta, delta.file};
      }
    }
  }
  return {FetchPlan::Kind::kMap, record.map};
}

std::string to_text(const FetchPlan& plan) {
  if (plan.kind == FetchPlan::Kind::kNothing) return "nothing";
  return concat(plan.kind == FetchPlan::Kind::kDelta ? "delta " : "map ", plan.file.name, " ",
                plan.file.size, " ", to_hex(plan.file.sha256));
}

}  // namespace sightline
