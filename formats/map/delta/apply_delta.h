#pragma once

#include <cstdint>
#include <filesystem>

#include "formats/base/hash.h"
#include "formats/base/result.h"

// Brings a map up to date with a delta (schemas/delta_format.md), on a machine that may lose power
// at any moment and has 64 MiB of memory to spare for it.

namespace sightline {

struct ApplyReport {
  bool was_there = false;  // the map is the result already: nothing was done
  Digest root_digest{};    // of the map that is in place now
  std::uint64_t result_size = 0;
  std::uint64_t copied_bytes = 0;  // from the base
  std::uint64_t kept_bytes = 0;    // made by an earlier apply that did not come to its end
};

// Where the result is made, and where the map before the last apply is kept.
std::filesystem::path part_path(const std::filesystem::path& map);
std::filesystem::path previous_path(const std::filesystem::path& map);

// `map` becomes the delta's result; the map that it was stays beside it. At every moment `map` is
// one of the two, whole; whatever stopped it, the same call goes on. Nothing is written before the
// delta's front and the base have been checked, and `map` changes only after all of the result has
// been: bytes, digests of blocks and tiles, root digest. A second process on the same map is
// refused (cannot-open) as long as the first is at work. Errors: those of the checks that
// schemas/delta_format.md lists; disk-full, cannot-open, cannot-read, cannot-write.
Result<ApplyReport> apply_delta(const std::filesystem::path& delta,
                                const std::filesystem::path& map);

// The same with the result in another file, which must not exist; `map` stays. No map is kept.
Result<ApplyReport> apply_delta_to(const std::filesystem::path& delta,
                                   const std::filesystem::path& map,
                                   const std::filesystem::path& out);

// Makes `map` what it was before the last apply, after checking all of that. Returns its root
// digest. Errors: file-not-found where there is none; those of check_map_digests(); cannot-write.
Result<Digest> roll_back(const std::filesystem::path& map);

}  // namespace sightline
