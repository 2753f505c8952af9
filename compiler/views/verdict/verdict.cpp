#include "compiler/views/verdict/verdict.h"

#include <algorithm>

#include "compiler/views/verdict/verdict_sentences.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

using Thresholds = VerdictThresholds;

// Rounding of sums must not decide.
constexpr double kSlack = 1e-9;

bool goes_by_looks(AnswerKind kind) { return kind != AnswerKind::kRange; }

const RangeTable& table_of(const CompiledMap& map, AnswerKind kind) {
  return goes_by_looks(kind) ? map.looks->ranges : map.ranges;
}

const LimitQuality& quality_of(const CompiledMap& map, AnswerKind kind, std::size_t limit) {
  return goes_by_looks(kind) ? map.looks->quality[limit] : map.quality[limit];
}

std::vector<AnswerKind> kinds_of(const CompiledMap& map, std::size_t limit) {
  if (!map.looks) return {AnswerKind::kRange};
  const std::optional<LookPlan>& plan = map.looks->ranges.plan;
  const bool has_plan = plan && map.ranges.promises[limit].limit_m >= plan->limit_m;
  if (has_plan) return {AnswerKind::kPlan, AnswerKind::kLook, AnswerKind::kRange};
  return {AnswerKind::kLook, AnswerKind::kRange};
}

double share_of(std::size_t count, std::size_t all) {
  return all > 0 ? static_cast<double>(count) / static_cast<double>(all) : 0.0;
}

// Whether no look and no range of the map is good enough there.
bool is_unmet(const CompiledMap& map, std::size_t site, std::size_t limit) {
  const auto is_unmet_in = [&](const RangeTable& table) {
    return (table.flags_of(site, limit) & kUnmet) != 0;
  };
  return is_unmet_in(map.ranges) && (!map.looks || is_unmet_in(map.looks->ranges));
}

// Sets the share of places with an answer and the longest stretch of neighbouring ones without.
void find_unmet(const CompiledMap& map, std::size_t limit, LimitVerdict& verdict) {
  const std::vector<Site>& sites = map.sites.sites;
  std::optional<std::size_t> begin;
  std::size_t unmet_count = 0;
  for (std::size_t site = 0; site < sites.size(); ++site) {
    const bool is_open = is_unmet(map, site, limit);
    if (!is_open || (begin && sites[site].run != sites[*begin].run)) begin.reset();
    if (!is_open) continue;
    ++unmet_count;
    if (!begin) begin = site;
    const double length_m = sites[site].s_m - sites[*begin].s_m;
    if (length_m <= verdict.unmet_m) continue;
    verdict.unmet_m = length_m;
    verdict.unmet_site = *begin;
  }
  verdict.answered_share = 1.0 - share_of(unmet_count, sites.size());
}

// What the map has of its localization drive: no replay, so neither a plan nor lost tracks nor
// times.
std::optional<AnswerScore> own_score(const CompiledMap& map, AnswerKind kind, std::size_t limit) {
  if (kind == AnswerKind::kPlan) return std::nullopt;
  const LimitQuality& quality = quality_of(map, kind, limit);
  const std::size_t sites = map.sites.sites.size();
  const double answered = 1.0 - share_of(quality.unmet_count, sites);
  const double coverage = quality.measured_coverage;
  AnswerScore score;
  score.kind = kind;
  score.coverage = coverage;
  score.answered_coverage = answered > 0.0 ? std::min(1.0, coverage / answered) : 1.0;
  return score;
}

const AnswerScore* find_score(const LimitFigures& figures, AnswerKind kind) {
  const auto found = std::ranges::find(figures.answers, kind, &AnswerScore::kind);
  return found == figures.answers.end() ? nullptr : &*found;
}

// One kind of answer against the target.
struct Trial {
  AnswerScore score;
  std::optional<ConstantScore> constant;
  std::optional<ConstantScore> same_work;

  [[nodiscard]] bool loses_more() const {
    return constant && score.lost_count.value_or(0) > constant->lost_count.value_or(0);
  }
  [[nodiscard]] bool reaches(double target) const {
    return score.answered_coverage >= target - kSlack && !loses_more();
  }
  // Than a fixed choice that is as good.
  [[nodiscard]] bool needs_more_work() const {
    return constant && constant->coverage >= score.coverage - kSlack &&
           constant->lost_count.value_or(0) <= score.lost_count.value_or(0) &&
           score.work_ratio > Thresholds::kMoreWork * constant->work_ratio + kSlack;
  }
  [[nodiscard]] bool is_bad(double target) const {
    const double allowed = Thresholds::kBadMisses * (1.0 - target);
    return 1.0 - score.answered_coverage > allowed + kSlack || loses_more();
  }
};

std::vector<Trial> trials_of(const CompiledMap& map, const EvaluationFigures* evaluation,
                             Evidence evidence, std::size_t limit) {
  std::vector<Trial> trials;
  for (const AnswerKind kind : kinds_of(map, limit)) {
    if (evidence == Evidence::kOwnDrive) {
      const std::optional<AnswerScore> score = own_score(map, kind, limit);
      if (score) trials.push_back({*score, std::nullopt, std::nullopt});
    }
    if (evidence != Evidence::kEvaluation) continue;
    const LimitFigures& figures = evaluation->limits[limit];
    const AnswerScore* const score = find_score(figures, kind);
    if (score == nullptr) continue;
    const auto copied = [](const ConstantScore* constant) {
      return constant != nullptr ? std::optional(*constant) : std::nullopt;
    };
    const double same_work = Thresholds::kMoreWork * score->work_ratio;
    trials.push_back({*score, copied(best_constant(figures, *score)),
                      copied(best_constant_within(figures, same_work))});
  }
  return trials;
}

// The first that reaches the target and needs no more work than a fixed choice; else the first
// that reaches it.
std::vector<Trial>::const_iterator best_of(const std::vector<Trial>& trials, double target) {
  const auto reaches = [&](const Trial& trial) { return trial.reaches(target); };
  const auto is_cheap = [&](const Trial& trial) {
    return reaches(trial) && !trial.needs_more_work();
  };
  const auto cheap = std::ranges::find_if(trials, is_cheap);
  return cheap != trials.end() ? cheap : std::ranges::find_if(trials, reaches);
}

// Sets verdict, recommended answer and reason by what was measured.
void judge_trials(const std::vector<Trial>& trials, LimitVerdict& verdict) {
  const Trial& first = trials.front();
  const auto found = best_of(trials, verdict.target);
  const Trial& taken = found == trials.end() ? first : *found;
  verdict.score = taken.score;
  verdict.constant = taken.constant;
  verdict.same_work = taken.same_work;
  if (found != trials.begin() && found != trials.end()) verdict.recommended = taken.score.kind;
  if (!first.reaches(verdict.target)) {
    verdict.reason = why_missed(first.score, first.constant, verdict);
    if (found != trials.end()) verdict.reason += "; " + reaching(taken.score.kind);
  }
  if (found == trials.end()) {
    verdict.verdict = taken.is_bad(verdict.target) ? MapVerdict::kBad : MapVerdict::kPartly;
    return;
  }
  if (taken.needs_more_work()) {
    verdict.reason += concat(verdict.reason.empty() ? "" : ". ", why_more_work(verdict));
  }
  verdict.verdict = verdict.reason.empty() ? MapVerdict::kGood : MapVerdict::kPartly;
}

bool is_answered(const LimitVerdict& verdict) {
  return verdict.answered_share >= Thresholds::kLeastAnswered - kSlack &&
         verdict.unmet_m < Thresholds::kUnmetStretch_m;
}

void lower(MapVerdict to, std::string reason, LimitVerdict& verdict) {
  if (verdict.verdict != MapVerdict::kGood) return;
  verdict.verdict = to;
  verdict.reason = std::move(reason);
}

double judged_share(const CompiledMap& map, const EvaluationFigures* evaluation,
                    Evidence evidence) {
  const std::size_t judged = evidence == Evidence::kEvaluation
                                 ? evaluation->judged_count
                                 : map.measurement.measured_site_count;
  return share_of(judged, map.sites.sites.size());
}

LimitVerdict judge_limit(const CompiledMap& map, const EvaluationFigures* evaluation,
                         Evidence evidence, std::size_t limit) {
  const LimitPromise& promise = map.ranges.promises[limit];
  LimitVerdict verdict;
  verdict.limit_m = promise.limit_m;
  if (promise.alpha > 0.0) verdict.target = 1.0 - promise.alpha;
  verdict.recommended = kinds_of(map, limit).front();
  const std::vector<Trial> trials = trials_of(map, evaluation, evidence, limit);
  if (!trials.empty()) judge_trials(trials, verdict);
  const LimitQuality& quality = quality_of(map, verdict.recommended, limit);
  verdict.recommended_share = 1.0 - share_of(quality.unmet_count, map.sites.sites.size());
  verdict.has_looks = map.looks.has_value();
  verdict.expected_coverage = quality.expected_coverage;
  find_unmet(map, limit, verdict);
  if (!is_answered(verdict)) lower(MapVerdict::kPartly, why_unanswered(verdict), verdict);
  const double judged = judged_share(map, evaluation, evidence);
  if (judged < Thresholds::kLeastJudged - kSlack) {
    lower(MapVerdict::kPartly, concat("Only ", percent(judged), " of the places were judged"),
          verdict);
  }
  return verdict;
}

Evidence evidence_of(const CompiledMap& map, const EvaluationFigures* evaluation) {
  if (map.sites.sites.empty() || map.ranges.promises.empty()) return Evidence::kNone;
  if (evaluation != nullptr && !evaluation->is_simulated && evaluation->judged_count > 0) {
    return Evidence::kEvaluation;
  }
  const bool is_measured = map.measurement.measured_site_count > 0 &&
                           map.measurement.reference != ErrorReference::kSimulated;
  return is_measured ? Evidence::kOwnDrive : Evidence::kNone;
}

std::string promise_of(const CompiledMap& map, const LimitVerdict& limit, std::size_t index) {
  const RangeTable& table = table_of(map, limit.recommended);
  return as_sentence(table.promises[index].statement);
}

// From good to bad; what is not judged decides where nothing is.
int rank(MapVerdict verdict) {
  switch (verdict) {
    case MapVerdict::kNotJudged:
      return 0;
    case MapVerdict::kGood:
      return 1;
    case MapVerdict::kPartly:
      return 2;
    case MapVerdict::kBad:
      break;
  }
  return 3;
}

void decide(MapJudgement& judgement) {
  const auto worst = std::ranges::max_element(
      judgement.limits, {}, [](const LimitVerdict& limit) { return rank(limit.verdict); });
  judgement.deciding = static_cast<std::size_t>(worst - judgement.limits.begin());
  judgement.verdict = worst->verdict;
  judgement.reason = as_sentence(worst->reason);
}

// Long stretches whose poses rest on an assumed speed.
std::vector<UnconstrainedStretch> assumed_stretches(const TrajectoryQuality& trajectory) {
  std::vector<UnconstrainedStretch> assumed;
  for (const UnconstrainedStretch& stretch : trajectory.unconstrained) {
    if (stretch.is_assumed() && stretch.way_m >= Thresholds::kAssumed_m) assumed.push_back(stretch);
  }
  return assumed;
}

// The poses of the map, by which its answers were measured: a drive through it does not judge them.
void judge_poses(const TrajectoryQuality& trajectory, const VerdictFiles& files,
                 MapJudgement& judgement) {
  const std::vector<UnconstrainedStretch> assumed = assumed_stretches(trajectory);
  if (!assumed.empty()) {
    const std::string sentence = as_sentence(why_assumed(assumed));
    const bool is_by_own_drive =
        judgement.verdict == MapVerdict::kNotJudged && judgement.evidence != Evidence::kNone;
    if (is_by_own_drive) judgement.reason.clear();
    judgement.reason += concat(judgement.reason.empty() ? "" : " ", sentence);
    if (judgement.verdict == MapVerdict::kGood || is_by_own_drive) {
      judgement.verdict = MapVerdict::kPartly;
      judgement.next = listing_command(files, "lists the stretches that scans do not constrain");
    }
  }
  const std::size_t pieces = trajectory.pieces.size();
  if (pieces < 2) return;
  judgement.verdict = MapVerdict::kBad;
  judgement.reason = concat("The trajectory has ", pieces,
                            " pieces that are not connected: their relative position is unknown.");
  judgement.next = listing_command(files, "lists the pieces");
}

}  // namespace

std::string_view word_of(MapVerdict verdict) {
  static constexpr std::string_view kWords[] = {"good", "partly", "bad", "not judged"};
  return kWords[static_cast<std::size_t>(verdict)];
}

std::string_view colour_of(MapVerdict verdict) {
  static constexpr std::string_view kColours[] = {"green", "yellow", "red", "grey"};
  return kColours[static_cast<std::size_t>(verdict)];
}

namespace {

std::string why_own(DriveOrigin origin) {
  return origin == DriveOrigin::kKnown ? "Only a known drive has tested the map"
                                       : "Only its own drive has tested the map";
}

}  // namespace

MapJudgement judge_map(const CompiledMap& map, const EvaluationFigures* evaluation,
                       const VerdictFiles& files) {
  MapJudgement judgement;
  judgement.evidence = evidence_of(map, evaluation);
  const bool is_evaluated = judgement.evidence == Evidence::kEvaluation;
  judgement.drive = is_evaluated ? evaluation->drive : map.measurement.localization_drive;
  judgement.origin = is_evaluated ? evaluation->origin : DriveOrigin::kOther;
  judgement.is_own_drive = judgement.evidence == Evidence::kOwnDrive || is_own(judgement.origin);
  judgement.has_other_scans =
      !map.tile_drives && map.measurement.mapping_scans == name_of(ScanSelection::kEven);
  judgement.is_replayed = is_evaluated && evaluation->scan_count > 0;
  judgement.judged_count = !is_evaluated           ? map.measurement.measured_site_count
                           : judgement.is_replayed ? evaluation->scan_count
                                                   : evaluation->judged_count;
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    judgement.limits.push_back(judge_limit(map, evaluation, judgement.evidence, limit));
    if (judgement.is_own_drive) {
      lower(MapVerdict::kNotJudged, why_own(judgement.origin), judgement.limits.back());
    }
  }
  if (!judgement.limits.empty()) {
    decide(judgement);
    const LimitVerdict& limit = judgement.limits[judgement.deciding];
    judgement.figures = as_sentence(figures_sentence(judgement, limit));
    judgement.promise = promise_of(map, limit, judgement.deciding);
  }
  judgement.next = next_command(judgement, files);
  if (map.trajectory) judge_poses(*map.trajectory, files, judgement);
  return judgement;
}

}  // namespace sightline
