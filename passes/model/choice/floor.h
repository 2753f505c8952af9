#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "formats/model/error_model.h"
#include "passes/model/choice/own_evidence.h"
#include "passes/model/promise/promise_text.h"
#include "passes/model/promise/selection.h"

// The floor of a choice is a lower bound, from the street's own evidence, of how well one static
// answer does there: a choice that does no better at a higher cost is replaced, so it caps cost.

namespace sightline {

// 1 - residual / total sum of squares of the model's out-of-fold means, range by range and added
// up: what it explains of places beyond what the range alone explains. 0 where all labels of each
// range are one.
double explained_share(const ErrorModel& model);

// A promise is worth this much: a static answer must be cheaper by more than a tenth to replace it.
inline constexpr double kPromiseWorth = 1.1;

// Whether blocks of route prove that a share of misses of 1 - coverage stays within alpha, by
// conformal risk control (passes/model/promise/calibration.h), sites in place of blocks of misses.
bool is_proven(double block_count, double alpha, double coverage);

struct FloorOptions {
  double static_coverage = 0.95;  // that a static answer must reach by the street's own evidence
  bool is_promised = false;       // the choice comes with a promise, which a static answer loses
  double alpha = 0.05;            // of that promise
  // Of route that the street's own evidence is of, 60 m each: how well it proves a static answer.
  double block_count = std::numeric_limits<double>::infinity();
  double explained = 0.0;     // explained_share of the model
  bool is_too_short = false;  // the model is of a drive too short to learn from
  bool is_simulated = false;  // the model knows simulated errors alone, which teach nothing
};

// A route, and within how many metres of it a site looks as far as any other.
struct DilatedRoute {
  std::vector<RoutePoint> route;
  double dilation_m = 0.0;
};

// Whether the model explains nothing, or is of too short a drive.
bool says_nothing(const FloorOptions& options);
// Why a static answer is taken: of these, else that it is cheaper.
Reason why_static(const FloorOptions& options);

// Gives every site the street's best static answer where the model says nothing of it, or where
// that answer is cheaper than `choice` and covers as much by the street's own evidence: the lesser
// of what the choice covers and static_coverage. If the choice covers no site by that evidence,
// costs are not compared.
//
// A choice with a promise is replaced only if the static answer is cheaper by more than a tenth and
// is proven: n / (n + 1) misses + 1 / (n + 1) must be at most alpha, where n is the number of
// blocks of the street. The promise met the same bound on drives that its model was not trained on.
//
// Where the choice is replaced all sites are flagged kStatic, and kUnmet where the own error at
// that range exceeds the limit. Nothing is returned where the choice is kept.
std::optional<StaticAnswers> apply_floor(const OwnEvidence& evidence, double limit_m,
                                         const FloorOptions& options, Choice& choice);

// What simulation asks for where nothing else is known: each site takes the shortest range whose
// own error is within the limit, dilated as every choice is, but none cheaper than the static
// answer for 80 % of the sites and none dearer than that for static_coverage (the dearer where no
// answer is within the limit). Simulation ranks places better than it measures how good they are.
// Therefore a range that is too short at more than one site in five is used at none. Flags are set
// as by apply_floor.
StaticAnswers take_simulated(const OwnEvidence& evidence, double limit_m, double static_coverage,
                             const DilatedRoute& dilated, Choice& choice);

// Gives a site the static answer, flagged in the same way.
void take_static(const OwnEvidence& evidence, double limit_m, std::uint8_t range_index,
                 Reason reason, std::size_t site, Choice& choice);

// Gives refused sites (kExtrapolated) the static answer, flagged in the same way.
void refused_take_static(const OwnEvidence& evidence, double limit_m, double static_coverage,
                         Choice& choice);

}  // namespace sightline
