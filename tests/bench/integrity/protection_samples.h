#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/reader/protection_table.h"
#include "tests/bench/integrity/closed_loop.h"

namespace sightline {

// A matched scan of a drive of a generated world.
struct KindSample {
  std::string kind;  // of place
  std::uint64_t seed = 0;
  std::size_t scan = 0;  // 1 m apart
  MatchSample sample;    // from a tracking start
};

// Lines of integrity_bench --samples. Error: bad-value, a line that is none.
Result<std::vector<KindSample>> read_samples(const std::string& path);

// The returned pose's errors, and their standard deviations, by axis.
struct AxisErrors {
  ProtectionFactors errors{};
  ProtectionFactors sigmas{};
};
AxisErrors returned_errors(const MatchSample& sample, double covariance_factor);

// 60 m of one kind of place of one world, in the order of the scans.
struct Block {
  std::string kind;
  std::vector<MatchSample> samples;
};
// Blocks that a kind of place does not fill are left out.
std::vector<Block> blocks_of(const std::vector<KindSample>& samples);
PlaceGroup group_of_world(const std::string& kind);

// All rows. A group of fewer than 99 blocks has the bounds of all blocks together, each with the
// covariance of its own group; infinite where these are fewer than 99 too.
std::array<ProtectionRow, kPlaceGroups> fitted_rows(const std::vector<Block>& blocks);

}  // namespace sightline
