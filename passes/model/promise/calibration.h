#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/annotation/range_table.h"
#include "formats/model/error_model.h"
#include "passes/model/promise/calibration_drives.h"
#include "passes/model/promise/selection.h"

// Sets p*, the probability that a chosen range must reach. The threshold at which a vehicle takes a
// second look is set by passes/localize/calibrate_plan.h.

namespace sightline {

// How strict must the threshold be so that misses stay rare? Decided on places that the trees never
// saw, and block by block: sites of one block see the same walls and are no independent witnesses.

// Misses of the rule at each of some ascending thresholds, stricter ones last.
struct Misses {
  std::vector<double> thresholds;
  std::vector<std::uint32_t> sites_in_block;         // [block], none 0
  std::vector<std::vector<std::uint32_t>> in_block;  // [threshold][block]: sites over the limit
};

struct RiskOptions {
  double alpha = 0.05;  // share of misses allowed
  double delta = 0.1;   // learn-then-test: how often the promise may fail
};

struct RiskDecision {
  double threshold = 0.0;
  bool is_earned = false;
  double miss_share = 0.0;          // of all calibration sites, at the threshold
  std::uint32_t needed_blocks = 0;  // with fewer, no threshold can earn the promise
};

// The least threshold at which the share of misses seen, and at every stricter threshold, is at
// most alpha; where there is none, the least at which that share is as small as it gets. Promises
// nothing.
RiskDecision decide_empirically(const Misses& misses, double alpha);

// Conformal risk control (Angelopoulos, Bates, Fisch, Lei, Schuster 2022): the least threshold with
// n/(n+1) mean loss + 1/(n+1) <= alpha over n exchangeable blocks; a block's loss is its share of
// misses, made monotone by its worst stricter threshold. Then a further block's expected share of
// misses is at most alpha. Not earned: as decide_empirically.
RiskDecision decide_conformally(const Misses& misses, const RiskOptions& options);

// Learn then test (Angelopoulos, Bates, Candes, Jordan, Lei 2021): thresholds are tested from the
// strictest down, with Hoeffding's p-value exp(-n kl(mean loss, alpha)), until one exceeds delta.
// With confidence 1 - delta the share of misses is at most alpha. Not earned: as
// decide_empirically.
RiskDecision decide_by_testing(const Misses& misses, const RiskOptions& options);

// The share of misses at one threshold, by its index.
double miss_share(const Misses& misses, std::size_t threshold);

struct CalibrationOptions {
  RiskControl risk_control = RiskControl::kConformal;
  double alpha = 0.05;  // 0: the strictest of 1, 2, 5 and 10 % that is earned, 5 % where none is
  double delta = 0.1;
  double fixed_threshold = 0.8;
  double dilation_m = 3.0;
};

// One limit calibrated on the model's own sites.
struct Calibration {
  LimitPromise promise;
  Choice choice;  // of the model's sites, at the threshold
};

// Sets p* of one limit for one kind of case by applying the probability rule, with dilation and
// with `tighter` (the choice for the next tighter limit; null for the tightest) as cap, to the
// model's out-of-fold predictions, and counting misses block by block. A promise is earned only
// where they were counted on drives that the trees did not learn from
// (passes/model/promise/calibration_drives.h); elsewhere the threshold is kept, and the statement
// says that it is of this drive. Thresholds tried: 0.005, 0.010, ..., 1.
Calibration calibrate_probability(const ErrorModel& model, std::size_t limit, CaseKind kind,
                                  const CalibrationOptions& options, const Choice* tighter);

// What the mean rule reached out of fold; it promises nothing.
LimitPromise assess_mean_rule(const ErrorModel& model, std::size_t limit);

}  // namespace sightline
