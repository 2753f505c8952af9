#pragma once

#include <cstdint>
#include <string>

#include "formats/annotation/range_table.h"
#include "passes/model/promise/calibration_drives.h"
#include "passes/model/promise/risk_control.h"

// The one sentence of a promise: of which drives and places, what is promised, or why nothing is.
// All of them are written here, from numbers.

namespace sightline {

// Of a promise that is earned. It is about the mean over places: `worst_place_miss_share` is how
// far one may lie from it.
std::string earned_statement(const LimitPromise& promise, double worst_place_miss_share);

// Of what a model of generated worlds predicts: `promise` is about these, and was withdrawn.
std::string generated_statement(const LimitPromise& promise);

// Of a threshold whose bound holds, set on drives that the trees learnt from or on one alone.
std::string this_drive_statement(const LimitPromise& promise, const TrainingCard& card);

// Of a threshold that no bound was reached for.
std::string unearned_statement(const LimitPromise& promise,
                               const CalibrationDrives& calibration_drives,
                               const RiskDecision& decision);

// Of the mean rule.
std::string mean_rule_statement(const LimitPromise& promise);

// Of a map of which some sites alone have measured history.
std::string joined_statement(const LimitPromise& map_only, const LimitPromise& history);

// Of looks whose thresholds were set by groups of places.
std::string groups_statement(const LimitPromise& constrained, const LimitPromise& weak);

// Static answers in place of the model's choice, and what they reach.
struct StaticAnswers {
  Reason reason = Reason::kCheaper;
  double explained = 0.0;     // by the model, out of fold
  bool is_simulated = false;  // the evidence that `coverage` is by
  Look cheapest;              // both the same: one is taken everywhere
  Look dearest;
  double coverage = 0.0;        // share of sites within the limit
  double route_m = 0.0;         // of the map
  double needed_route_m = 0.0;  // for a promise, at least; 0: not known
};
std::string to_text(const StaticAnswers& answers, double limit_m);

// Why a promise that the model earned is not made for a map.
enum class NoPromise : std::uint8_t { kOnePlace, kUnlike, kProvenAnswer, kTighterLimit, kNoScans };
// `unlike_count` of `site_count` sites are extrapolated.
std::string withdrawn_statement(NoPromise why, std::size_t unlike_count = 0,
                                std::size_t site_count = 0);

// Why a promise is not kept that the map's own measurements contradict (choice/contradiction.h).
std::string contradicted_statement(const LimitPromise& promise, double share_within,
                                   std::uint32_t missed_blocks, std::uint32_t block_count);
bool is_contradicted(const LimitPromise& promise);  // its statement is of this kind

// "; of 2 drives here, ...": what answers reached on drives that were left out in turn.
std::string drives_text(std::size_t drive_count, double coverage, double limit_m);

// Whether errors are those against known poses. A match to the very map is no truth: against it
// errors vanish with range by construction.
bool are_poses_known(const TrainingCard& card);

// Whether blocks and buffer are so long that blocks do not see the same walls.
bool are_blocks_independent(const TrainingCard& card);

}  // namespace sightline
