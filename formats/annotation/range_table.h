#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/annotation/answer.h"
#include "formats/annotation/by_family.h"
#include "formats/artifact.h"
#include "formats/drive/look.h"
#include "formats/grid/site_shape.h"
#include "formats/record/fields.h"

namespace sightline {

enum class Selection : std::uint8_t { kMean, kProbability };
template <>
inline constexpr auto kNamesOf<Selection> = enum_names("mean", "probability");

// What sets the probability that is asked for (schemas/definitions.md, "Error model and
// choice of range").
enum class RiskControl : std::uint8_t { kConformal, kLearnThenTest, kEmpirical, kFixed };

// "conformal", "learn-then-test", "empirical", "fixed".
const std::vector<std::string>& risk_control_names();
const std::string& risk_control_name(RiskControl control);

// What a threshold can speak for (schemas/definitions.md, "Error model and choice of range").
enum class PromiseScope : std::uint8_t {
  kThisDrive,  // it was set on a drive that the trees learnt from too, or on one drive alone
  kNextDrive   // it was set on drives that the trees did not learn from
};
template <>
inline constexpr auto kNamesOf<PromiseScope> = enum_names("this-drive", "next-drive");

// Flags of a chosen range, as stored in the map.
// No range is good enough: the most probable one. The site is not answered, and no promise is about
// it.
inline constexpr std::uint8_t kUnmet = 1;
inline constexpr std::uint8_t kExtrapolated = 2;  // the model's answer lies outside its support
// The street's own static answer instead of the model's; 4 and 8 are flags of the vehicle's reader.
inline constexpr std::uint8_t kStatic = 16;
// No scan was ever seen here: what simulation found of the place decided. 32 and 64 are flags of
// the vehicle's reader.
inline constexpr std::uint8_t kSimulatedAnswer = 128;

// The promise behind the ranges of one limit.
struct LimitPromise {
  double limit_m = 0.0;
  std::string method;  // "mean", "conformal", "learn-then-test", "empirical", "fixed"
  double probability_threshold = 0.0;  // p*; 0 under the mean rule
  double history_threshold = 0.0;      // p* of sites with measured history; 0 where there are none
  double alpha = 0.0;                  // share of the answered sites that may miss
  double delta = 0.0;                  // learn-then-test only
  // Of the calibration: blocks of route, the places they lie in, and the drives that measured them.
  std::uint32_t block_count = 0;
  std::uint32_t place_count = 0;
  std::uint32_t drive_count = 0;
  PromiseScope scope = PromiseScope::kThisDrive;
  bool is_earned = false;  // of the next drive, at answered sites; false: of this drive, too few
                           // blocks, or no threshold reached alpha
  // Out of fold, on the range chosen after dilation: misses of the answered sites, and the share of
  // sites that are answered (not flagged kUnmet).
  double calibration_miss_share = 0.0;
  double answered_share = 1.0;
  std::string statement;  // one sentence for people: what is promised, or why nothing is
};
SIGHTLINE_FIELDS(LimitPromise, limit_m, method, probability_threshold, history_threshold, alpha,
                 delta, block_count, place_count, drive_count, scope, is_earned,
                 calibration_miss_share, answered_share, statement)

// How to look at every site, chosen from the looks of a family.
struct RangeTable {
  std::vector<Look> looks;  // the choice, from the cheapest to the dearest
  Selection selection = Selection::kProbability;
  double dilation_m = 0.0;
  bool extrapolated_takes_static = true;  // a site unlike the training takes the static answer
  std::vector<LimitPromise> promises;     // one per limit, ascending limit_m
  std::uint32_t site_count = 0;
  std::vector<std::uint8_t> range_index;  // [site][limit], into looks;    a looser limit never
                                          // looks further
  std::vector<std::uint8_t> flags;        // [site][limit]
  std::vector<Reason> reasons;            // [site][limit]: never kNone
  // How a vehicle localizes that tracks, wherever it is; looks that take a sample alone may have
  // it.
  std::optional<LookPlan> plan;

  [[nodiscard]] SiteShape shape() const { return {promises.size()}; }

  [[nodiscard]] std::size_t range(std::size_t site, std::size_t limit) const {
    return range_index[shape().index(site, limit)];
  }
  [[nodiscard]] double range_m(std::size_t site, std::size_t limit) const {
    return looks[range(site, limit)].range_m;
  }
  [[nodiscard]] std::uint8_t flags_of(std::size_t site, std::size_t limit) const {
    return flags[shape().index(site, limit)];
  }
  [[nodiscard]] Reason reason(std::size_t site, std::size_t limit) const {
    return reasons[shape().index(site, limit)];
  }
};
SIGHTLINE_FIELDS(RangeTable, looks, selection, dilation_m, extrapolated_takes_static, promises,
                 site_count, range_index, flags, reasons, plan)

template <>
struct ArtifactTraits<RangeTable> {
  static constexpr std::string_view kName = "range-table";
  static constexpr std::uint32_t kVersion = 10;
};

// Of its sites, those flagged kSimulatedAnswer for some limit.
std::uint32_t simulated_site_count(const RangeTable& table);

// Error: invalid-artifact, also for an earned promise that is of this drive alone.
Result<void> validate(const RangeTable& table);
Table dump(const RangeTable& table);

}  // namespace sightline
