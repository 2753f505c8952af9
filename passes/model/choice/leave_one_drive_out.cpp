#include "passes/model/choice/leave_one_drive_out.h"

#include <algorithm>
#include <utility>

#include "formats/annotation/measured_drives.h"
#include "formats/base/parallel.h"
#include "passes/model/choice/floor.h"
#include "passes/model/forest/measured_columns.h"
#include "passes/model/forest/predict_error.h"

namespace sightline {
namespace {

// A site that a drive passed which was left out, and others too.
struct DriveCase {
  std::size_t drive = 0;
  std::size_t site = 0;
};

std::vector<DriveCase> cases_of(std::span<const LeftOutDrive> left_out) {
  std::vector<DriveCase> cases;
  for (std::size_t drive = 0; drive < left_out.size(); ++drive) {
    const LeftOutDrive& one = left_out[drive];
    for (std::size_t site = 0; site < one.predicted.site_count; ++site) {
      const bool is_case =
          one.measured.scan_of_site[site] >= 0 && one.predicted.has_history[site] == 1;
      if (is_case) cases.push_back({drive, site});
    }
  }
  return cases;
}

// Judges answers on the cases.
class Judge {
 public:
  Judge(std::span<const LeftOutDrive> left_out, const OwnEvidence& evidence, double limit_m)
      : left_out_(left_out), evidence_(evidence), limit_m_(limit_m), cases_(cases_of(left_out)) {}

  [[nodiscard]] std::size_t case_count() const { return cases_.size(); }

  // Coverage: of the cases that the rule answers; 0 where it answers none. Cost: of all.
  [[nodiscard]] Standing of_rule(const RuleAt& rule_at, double threshold) const {
    std::vector<Choice> choices;
    for (const LeftOutDrive& drive : left_out_) {
      choices.push_back(rule_at(drive.predicted, threshold));
    }
    return standing([&](const DriveCase& of) { return choices[of.drive].range_index[of.site]; },
                    [&](const DriveCase& of) { return choices[of.drive].is_answered(of.site); });
  }
  // Coverage: of all cases.
  [[nodiscard]] Standing of_static(std::uint8_t range) const {
    return standing([&](const DriveCase&) { return range; }, [](const DriveCase&) { return true; });
  }

 private:
  template <class RangeOf, class IsAnswered>
  [[nodiscard]] Standing standing(const RangeOf& range_of, const IsAnswered& is_answered) const {
    std::vector<double> within;
    std::vector<double> costs;
    for (const DriveCase& of : cases_) {
      const std::size_t range = range_of(of);
      costs.push_back(evidence_.cost[evidence_.shape().index(of.site, range)]);
      if (!is_answered(of)) continue;
      const double error_m = left_out_[of.drive].measured.row(of.site, range).mean_m;
      within.push_back(error_m <= limit_m_ ? 1.0 : 0.0);
    }
    const double answered_count = std::max<double>(1.0, static_cast<double>(within.size()));
    return {ordered_sum(within) / answered_count,
            ordered_sum(costs) / static_cast<double>(cases_.size())};
  }

  std::span<const LeftOutDrive> left_out_;
  const OwnEvidence& evidence_;
  double limit_m_;
  std::vector<DriveCase> cases_;
};

bool covers(const Standing& standing, double coverage) {
  constexpr double kRounding =
      1e-12;  // shares of cases that are equal may differ in their last bit
  return standing.coverage >= coverage - kRounding;
}

// Covers more; of equal ones cheaper.
bool is_better(const Standing& a, const Standing& b) {
  return a.coverage > b.coverage || (a.coverage == b.coverage && a.cost < b.cost);
}

// At the least threshold that covers enough; where none does, at that which covers most.
DriveVote best_of_rule(const Judge& judge, double coverage, const RuleAt& rule_at) {
  DriveVote best;
  for (const double threshold : tried_thresholds()) {
    const Standing standing = judge.of_rule(rule_at, threshold);
    const bool is_enough = covers(standing, coverage);
    if (is_enough || best.threshold == 0.0 || is_better(standing, best.standing)) {
      best.threshold = threshold;
      best.standing = standing;
    }
    if (is_enough) break;
  }
  return best;
}

DriveVote best_static_of(const Judge& judge, double coverage, const OwnEvidence& evidence) {
  DriveVote best;
  bool does_cover = false;
  for (std::size_t look = 0; look < evidence.looks.size(); ++look) {
    const auto range = static_cast<std::uint8_t>(look);
    const Standing standing = judge.of_static(range);
    const bool covers_too = covers(standing, coverage);
    const bool is_cheaper = standing.cost < best.standing.cost;
    const bool is_chosen = !best.everywhere || (covers_too && (!does_cover || is_cheaper)) ||
                           (!covers_too && !does_cover && is_better(standing, best.standing));
    if (!is_chosen) continue;
    best.everywhere = range;
    best.standing = standing;
    does_cover = covers_too;
  }
  return best;
}

// Of two answers: one that covers before one that does not; else the cheaper of those that do, the
// better of those that do not.
bool is_preferred(const DriveVote& a, const DriveVote& b, double coverage) {
  const bool a_covers = covers(a.standing, coverage);
  const bool b_covers = covers(b.standing, coverage);
  if (a_covers != b_covers) return a_covers;
  return a_covers ? a.standing.cost < b.standing.cost : is_better(a.standing, b.standing);
}

}  // namespace

std::optional<DriveVote> leave_one_drive_out(std::span<const LeftOutDrive> left_out,
                                             const OwnEvidence& evidence,
                                             const DriveVoteOptions& options,
                                             const RuleAt& rule_at) {
  const Judge judge(left_out, evidence, options.limit_m);
  if (judge.case_count() == 0) return std::nullopt;
  const DriveVote rule = best_of_rule(judge, options.coverage, rule_at);
  const DriveVote everywhere = best_static_of(judge, options.coverage, evidence);
  DriveVote answer = is_preferred(everywhere, rule, options.coverage) ? everywhere : rule;
  answer.keeps_promise = !options.is_promised;
  if (options.is_promised) {
    DriveVote promised = rule;
    promised.threshold = std::max(rule.threshold, options.threshold);
    promised.standing = judge.of_rule(rule_at, promised.threshold);
    const bool is_worth =
        answer.standing.cost * kPromiseWorth < promised.standing.cost &&
        answer.standing.coverage >= std::min(promised.standing.coverage, options.coverage) &&
        is_proven(options.block_count, options.alpha, answer.standing.coverage);
    if (!is_worth) answer = promised;
    answer.keeps_promise = !is_worth;
  }
  answer.case_count = judge.case_count();
  answer.drive_count = left_out.size();
  return answer;
}

Result<std::vector<LeftOutDrive>> leave_out_in_turn(const PassContext& ctx,
                                                    const ByFamily<ErrorModel>& model,
                                                    const Sites& sites, const FactorTable& factors,
                                                    double support_margin) {
  std::vector<LeftOutDrive> left_out;
  std::vector<ByFamily<MeasuredError>> drives = measured_of_columns(factors);
  if (drives.size() < 2 || !model.ranges.card.knows_history) return left_out;
  // Columns are kept of drives by the model's localizer alone (predict_error).
  for (ByFamily<MeasuredError>& drive : drives) {
    drive.ranges.matching.localizer = model.ranges.card.localizer;
  }
  const std::vector<bool> is_independent = independence_of_columns(factors);
  PassContext quiet;  // warnings were given when all drives were used
  quiet.threads = ctx.threads;
  quiet.seed = ctx.seed;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (!is_independent[i]) continue;
    MeasuredDrives others;
    for (std::size_t other = 0; other < drives.size(); ++other) {
      if (other != i) others.drives.push_back(drives[other]);
    }
    SIGHTLINE_ASSIGN(ByFamily<PredictedError> predicted,
                     predict_error(quiet, {.support_margin = support_margin}, model, sites,
                                   StoredTable(factors), {}, nullptr, &others));
    left_out.push_back({std::move(predicted.ranges), drives[i].ranges});
  }
  return left_out;
}

}  // namespace sightline
