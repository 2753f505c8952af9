#include "passes/model/choice/choices.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "passes/model/choice/contradiction.h"
#include "passes/model/choice/floor.h"
#include "passes/model/choice/leave_one_drive_out.h"
#include "passes/model/promise/promise_text.h"

// The rules of choose-ranges, at the end of this file in their order. They are applied limit by
// limit, from the tightest limit to the loosest. Each may change looks, their flags and their
// Reason, and may withdraw the promise: the last rule that applies decides.

namespace sightline {
namespace {

constexpr double kBlock_m = 60.0;  // of route

// The choice for one limit in the making.
struct LimitChoice {
  const ChooseRangesOptions& options;
  const ChoiceInputs& inputs;
  std::size_t limit;
  const Choice* tighter;  // of the next tighter limit; none for the tightest
  Calibrator& calibrator;
  LimitPromise promise = {};
  Choice choice = {};
  std::optional<DriveVote> vote = {};
  KindLooks looks = {};

  // That a static answer must reach: what alpha leaves, where it controls anything.
  [[nodiscard]] double static_coverage() const {
    constexpr double kUncontrolled = 0.95;
    const bool is_controlled =
        options.selection == Selection::kProbability && options.risk_control != RiskControl::kFixed;
    return is_controlled ? 1.0 - promise.alpha : kUncontrolled;
  }
  [[nodiscard]] double route_m() const {
    return static_cast<double>(inputs.sites.sites.size()) * inputs.sites.spacing_m;
  }
  [[nodiscard]] double block_count() const { return std::floor(route_m() / kBlock_m); }
  // Fewer blocks cannot earn a promise: n / (n + 1) loss + 1 / (n + 1) <= alpha.
  [[nodiscard]] double needed_route_m() const {
    return promise.alpha > 0.0 ? kBlock_m * std::ceil(1.0 / promise.alpha - 1.0 - 1e-9) : 0.0;
  }
  void withdraw(const std::string& statement) {
    promise.is_earned = false;
    promise.statement = statement;
  }
};

// What is promised of a map of which some sites have measured history.
LimitPromise joined(const LimitPromise& map_only, const LimitPromise& history) {
  LimitPromise promise = history;
  promise.is_earned = map_only.is_earned && history.is_earned;
  promise.alpha = std::max(map_only.alpha, history.alpha);
  promise.block_count = std::min(map_only.block_count, history.block_count);
  promise.place_count = std::min(map_only.place_count, history.place_count);
  promise.drive_count = std::min(map_only.drive_count, history.drive_count);
  promise.scope = std::min(map_only.scope, history.scope);
  promise.calibration_miss_share =
      std::max(map_only.calibration_miss_share, history.calibration_miss_share);
  promise.answered_share = std::min(map_only.answered_share, history.answered_share);
  promise.statement = joined_statement(map_only, history);
  return promise;
}

void calibrate(LimitChoice& now, const std::vector<std::uint8_t>* look_of_site) {
  const std::vector<std::uint8_t>& has_history = now.inputs.predicted.has_history;
  const auto history_count = std::ranges::count(has_history, std::uint8_t{1});
  now.promise = now.calibrator.next(CaseKind::kMapOnly, now.limit, look_of_site);
  if (history_count == 0) return;
  const LimitPromise map_only = now.promise;
  const LimitPromise history = now.calibrator.next(CaseKind::kHistory, now.limit, look_of_site);
  const bool is_everywhere = history_count == std::ssize(has_history);
  now.promise = is_everywhere ? history : joined(map_only, history);
  now.promise.probability_threshold = map_only.probability_threshold;
}

void calibrate_ranges(LimitChoice& now) { calibrate(now, nullptr); }

// Half of the share that may miss: with few blocks a promise leaves no more for misses that are
// seen, and each of them leaves sites without an answer.
void calibrate_looks(LimitChoice& now) {
  constexpr double kOfAlpha = 0.5;
  constexpr double kUncontrolled = 0.05;
  const bool is_controlled = now.options.risk_control != RiskControl::kFixed;
  const double miss_share = kOfAlpha * (is_controlled ? now.options.alpha : kUncontrolled);
  const double limit_m = now.inputs.predicted.limits_m[now.limit];
  now.looks = choose_kind_looks(*now.inputs.looks, limit_m, miss_share);
  std::vector<std::uint8_t> look_of_site;
  for (const TrainedSite& site : now.inputs.model.sites) {
    look_of_site.push_back(now.looks.at(site.kind));
  }
  calibrate(now, &look_of_site);
}

// Blocks of one place say how it varies within itself, not how the next place differs from it.
void promise_nothing_elsewhere(LimitChoice& now) {
  const std::vector<std::uint8_t>& is_own = now.inputs.predicted.out_of_fold;
  const bool is_elsewhere = std::ranges::count(is_own, std::uint8_t{1}) < std::ssize(is_own);
  if (now.promise.place_count > 1 || !is_elsewhere || !now.promise.is_earned) return;
  now.withdraw(withdrawn_statement(NoPromise::kOnePlace));
}

// Generated worlds and recorded streets are not exchangeable.
void mark_generated(LimitChoice& now) {
  if (!now.inputs.model.card.is_of_generated_worlds()) return;
  now.withdraw(generated_statement(now.promise));
}

void take_static_where_extrapolated(const LimitChoice& now, const PredictedError& predicted,
                                    Choice& choice) {
  mark_extrapolated(predicted, choice);
  if (!now.options.extrapolated_takes_static) return;
  refused_take_static(now.inputs.evidence, now.promise.limit_m, now.static_coverage(), choice);
}

// The threshold is of sites with history.
Choice choose_at(const LimitChoice& now, const PredictedError& predicted, double threshold) {
  Choice choice =
      choose_by_probability(predicted, now.limit, {now.promise.probability_threshold, threshold});
  take_static_where_extrapolated(now, predicted, choice);
  dilate(route_of(now.inputs.sites), now.options.dilation_m, choice);
  return choice;
}

// A promise is about places like those of the training; it says nothing where most sites are not.
void promise_nothing_where_unlike(LimitChoice& now) {
  const auto unlike_count = std::ranges::count_if(
      now.choice.flags, [](std::uint8_t flags) { return (flags & kExtrapolated) != 0; });
  const std::size_t site_count = now.choice.flags.size();
  const auto unlike = static_cast<std::size_t>(unlike_count);
  if (2 * unlike <= site_count || !now.promise.is_earned) return;
  now.withdraw(withdrawn_statement(NoPromise::kUnlike, unlike, site_count));
}

void choose_by_model(LimitChoice& now) {
  now.choice = choose_at(now, now.inputs.predicted, now.promise.history_threshold);
  promise_nothing_where_unlike(now);
}

// By the site's own evidence its look is good enough, or not.
void answer_by_evidence(LimitChoice& now, std::size_t site, Reason reason) {
  take_static(now.inputs.evidence, now.promise.limit_m, now.choice.range_index[site], reason, site,
              now.choice);
}

// [site]: p* of its group, with measured history or without.
std::vector<double> threshold_of_sites(const LimitChoice& now) {
  std::vector<double> thresholds;
  for (std::size_t site = 0; site < now.inputs.looks->kinds.size(); ++site) {
    const bool has_history = now.inputs.predicted.has_history[site] == 1;
    const CaseKind kind = has_history ? CaseKind::kHistory : CaseKind::kMapOnly;
    const auto group = static_cast<std::size_t>(group_of(now.inputs.looks->kinds[site]));
    thresholds.push_back(now.calibrator.group_thresholds(kind)[group]);
  }
  return thresholds;
}

void answer_by_model(LimitChoice& now) {
  std::vector<std::uint8_t> look_of_site;
  for (const PlaceKind kind : now.inputs.looks->kinds) {
    look_of_site.push_back(now.looks.at(kind));
  }
  now.choice = choose_given(now.inputs.predicted, now.limit, threshold_of_sites(now), look_of_site);
  mark_extrapolated(now.inputs.predicted, now.choice);
  promise_nothing_where_unlike(now);
  if (!now.options.extrapolated_takes_static) return;
  for (std::size_t site = 0; site < look_of_site.size(); ++site) {
    const bool is_unlike = (now.choice.flags[site] & kExtrapolated) != 0;
    if (is_unlike) answer_by_evidence(now, site, Reason::kExtrapolated);
  }
}

void assess_by_mean(LimitChoice& now) {
  now.promise = assess_mean_rule(now.inputs.model, now.limit);
  now.choice = choose_by_mean(now.inputs.predicted, now.promise.limit_m);
  take_static_where_extrapolated(now, now.inputs.predicted, now.choice);
}

void ask_drives(LimitChoice& now) {
  const bool is_controlled = now.options.risk_control != RiskControl::kFixed;
  if (!is_controlled || now.inputs.left_out.empty()) return;
  const DriveVoteOptions voting{.limit_m = now.promise.limit_m,
                                .coverage = now.static_coverage(),
                                .is_promised = now.promise.is_earned,
                                .threshold = now.promise.history_threshold,
                                .alpha = now.promise.alpha,
                                .block_count = now.block_count()};
  now.vote = leave_one_drive_out(now.inputs.left_out, now.inputs.evidence, voting,
                                 [&](const PredictedError& predicted, double threshold) {
                                   return choose_at(now, predicted, threshold);
                                 });
}

FloorOptions floor_of(const LimitChoice& now) {
  const ErrorModel& model = now.inputs.model;
  return {.static_coverage = now.static_coverage(),
          .is_promised = now.promise.is_earned,
          .alpha = now.promise.alpha,
          .block_count = now.block_count(),
          .explained = explained_share(model),
          .is_too_short = model.card.fold_count == 0,
          .is_simulated = model.card.reference == ErrorReference::kSimulated};
}

void withdraw_for(StaticAnswers taken, LimitChoice& now) {
  taken.route_m = now.route_m();
  taken.needed_route_m = now.needed_route_m();
  now.withdraw(to_text(taken, now.promise.limit_m));
}

void answer_by_evidence_alone(LimitChoice& now) {
  const FloorOptions floor = floor_of(now);
  if (!says_nothing(floor)) return;
  const Reason reason = why_static(floor);
  const OwnEvidence& evidence = now.inputs.evidence;
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    answer_by_evidence(now, site, reason);
  }
  const auto [cheapest, dearest] = std::ranges::minmax(now.choice.range_index);
  withdraw_for({reason, floor.explained, evidence.is_simulated, evidence.looks[cheapest],
                evidence.looks[dearest], now.looks.coverage},
               now);
}

// Where the drives voted, they decide at sites with history.
void put_floor(LimitChoice& now) {
  const ChoiceInputs& inputs = now.inputs;
  if (now.vote && std::ranges::count(inputs.predicted.has_history, std::uint8_t{0}) == 0) return;
  const FloorOptions floor = floor_of(now);
  const double limit_m = now.promise.limit_m;
  const std::optional<StaticAnswers> taken =
      floor.is_simulated
          ? take_simulated(inputs.evidence, limit_m, floor.static_coverage,
                           {route_of(inputs.sites), now.options.dilation_m}, now.choice)
          : apply_floor(inputs.evidence, limit_m, floor, now.choice);
  if (taken) withdraw_for(*taken, now);
}

void take_vote(LimitChoice& now) {
  if (!now.vote) return;
  const Choice at_vote = choose_at(now, now.inputs.predicted, now.vote->threshold);
  const std::vector<std::uint8_t>& has_history = now.inputs.predicted.has_history;
  for (std::size_t site = 0; site < has_history.size(); ++site) {
    if (has_history[site] == 0) continue;
    now.choice.range_index[site] = at_vote.range_index[site];
    now.choice.flags[site] = at_vote.flags[site];
    now.choice.reasons[site] = at_vote.reasons[site];
    if (!now.vote->everywhere) continue;
    take_static(now.inputs.evidence, now.promise.limit_m, *now.vote->everywhere, Reason::kDrives,
                site, now.choice);
  }
  now.promise.history_threshold = now.vote->threshold;
  if (now.promise.is_earned && !now.vote->keeps_promise) {
    now.withdraw(withdrawn_statement(NoPromise::kProvenAnswer));
  }
  now.promise.statement +=
      drives_text(now.vote->drive_count, now.vote->standing.coverage, now.promise.limit_m);
}

// The model's answers for a tighter limit were the cap of the calibration too. A static answer was
// not, and may ask for less than the choice that a promise was made of. (Of sites unlike the
// training a promise says nothing: choose_by_model.)
void look_no_further_than_for_tighter(LimitChoice& now) {
  if (now.tighter == nullptr) return;
  const std::vector<std::uint8_t> before = now.choice.range_index;
  cap_by_tighter(*now.tighter, now.choice);
  bool takes_static = false;
  for (std::size_t site = 0; site < before.size(); ++site) {
    const bool is_static = (now.tighter->flags[site] & (kStatic | kExtrapolated)) == kStatic;
    takes_static |= is_static && before[site] != now.choice.range_index[site];
  }
  if (!now.promise.is_earned || !takes_static) return;
  now.withdraw(withdrawn_statement(NoPromise::kTighterLimit));
}

// A threshold was set on maps that scans made; it says nothing of one whose scans are simulated.
void mark_simulated(LimitChoice& now) {
  const ChoiceInputs& inputs = now.inputs;
  if (!inputs.evidence.is_simulated) return;
  const bool has_labels = inputs.model.card.reference != ErrorReference::kSimulated;
  for (std::size_t site = 0; site < now.choice.flags.size(); ++site) {
    const bool was_measured = inputs.predicted.has_history[site] == 1 ||
                              (has_labels && inputs.predicted.out_of_fold[site] == 1);
    if (!was_measured) now.choice.flags[site] |= kSimulatedAnswer;
  }
  const std::vector<FeatureCard>& features = inputs.model.features;
  const bool knows_simulated =
      std::ranges::find(features, kSimulatedColumn, &FeatureCard::name) != features.end();
  if (knows_simulated || !now.promise.is_earned) return;
  now.withdraw(withdrawn_statement(NoPromise::kNoScans));
}

// Errors that were simulated, or of another localizer than the promise is for, say nothing of it.
bool judges_promise(const MeasuredError& measured, const ChoiceInputs& inputs) {
  return measured.reference != ErrorReference::kSimulated &&
         measured.matching.localizer == inputs.model.card.localizer &&
         measured.looks == inputs.predicted.looks &&
         measured.scan_of_site.size() == inputs.sites.sites.size();
}

void heed_measured(LimitChoice& now) {
  const MeasuredError* const measured = now.inputs.measured;
  if (!now.promise.is_earned || measured == nullptr) return;
  if (!judges_promise(*measured, now.inputs)) return;
  const std::optional<Contradiction> found = contradiction_of(
      now.inputs.sites, *measured, now.choice, now.promise.limit_m, now.promise.alpha);
  if (!found) return;
  now.withdraw(contradicted_statement(now.promise, found->share_within, found->missed_blocks,
                                      found->block_count));
}

using Rule = void (*)(LimitChoice& now);

constexpr Rule kByProbability[] = {
    // p* is calibrated on the model's own sites, separately for sites with measured history.
    calibrate_ranges,
    // No promise for sites in another place than the only one that the model learnt from.
    promise_nothing_elsewhere,
    // What a model of generated worlds promises is about such worlds: no promise here.
    mark_generated,
    // The cheapest look with P(error <= limit) >= p*, else the most probable one, flagged kUnmet.
    // An extrapolated look is flagged, and the site takes the static answer (kStatic) if the option
    // says so. Then dilation. No promise where more than half of the sites are extrapolated.
    choose_by_model,
    // If two drives or more are known here and p* is controlled, the drives vote.
    ask_drives,
    // By simulated errors alone, ranges are chosen from what was simulated at each site. Otherwise
    // all sites take one static answer if the model is from too short a drive, explains nothing out
    // of fold, or costs more than a static answer that covers as much. Then there is no promise.
    put_floor,
    // Sites with history are chosen again at the vote's threshold, or all take one static answer:
    // no promise where that is cheaper and proven.
    take_vote,
    // A site looks no further than for the next tighter limit: no promise if this takes over a
    // static answer.
    look_no_further_than_for_tighter,
    // In a map without scans, sites where no drive was measured are flagged kSimulatedAnswer; no
    // promise unless the model learnt from such maps.
    mark_simulated,
    // No promise if the errors that this compile measured contradict it (contradiction.h).
    heed_measured};

constexpr Rule kByKind[] = {
    // One look for each kind of place, by the errors measured here. p* is calibrated on the model's
    // sites with the looks of their kinds.
    calibrate_looks,
    // No promise for sites in another place than the only one that the model learnt from.
    promise_nothing_elsewhere,
    // What a model of generated worlds promises is about such worlds: no promise here.
    mark_generated,
    // Sites take the look of their kind, flagged kUnmet where P(error <= limit) < p*. Extrapolated
    // sites are flagged, and answered where their own evidence is within the limit (kStatic) if the
    // option says so. No promise where more than half of the sites are extrapolated.
    answer_by_model,
    // If the model is from too short a drive or explains nothing out of fold, all sites are
    // answered
    // by their own evidence. Then there is no promise.
    answer_by_evidence_alone,
    // As for ranges.
    look_no_further_than_for_tighter, mark_simulated};

constexpr Rule kByMean[] = {
    // The shortest range whose predicted mean error is within the limit, else the longest, flagged
    // kUnmet; extrapolated ones as by probability. No promise.
    assess_by_mean, mark_generated, look_no_further_than_for_tighter, mark_simulated};

}  // namespace

Chosen choose_all(const ChooseRangesOptions& options, const ChoiceInputs& inputs) {
  const bool is_mean = options.selection == Selection::kMean;
  const std::span<const Rule> rules = is_mean        ? std::span<const Rule>(kByMean)
                                      : inputs.looks ? std::span<const Rule>(kByKind)
                                                     : std::span<const Rule>(kByProbability);
  Calibrator calibrator(inputs.model, options);
  Chosen chosen;
  for (std::size_t limit = 0; limit < inputs.predicted.limits_m.size(); ++limit) {
    LimitChoice now{options, inputs, limit, limit > 0 ? &chosen.choices.back() : nullptr,
                    calibrator};
    for (const Rule rule : rules) rule(now);
    chosen.promises.push_back(std::move(now.promise));
    chosen.choices.push_back(std::move(now.choice));
  }
  return chosen;
}

}  // namespace sightline
