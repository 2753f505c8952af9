#include "compiler/views/verdict/evaluation_figures.h"

#include <algorithm>
#include <tuple>

#include "compiler/views/verdict/answered_shares.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

AnswerKind kind_of(TrackChoice choice) {
  if (choice == TrackChoice::kPlan) return AnswerKind::kPlan;
  return choice == TrackChoice::kLook ? AnswerKind::kLook : AnswerKind::kRange;
}

// Of a drive that was replayed.
LimitFigures figures_at(const CompiledMap& map, const DriveTracks& tracks, double limit_m) {
  LimitFigures figures;
  figures.limit_m = limit_m;
  AnsweredShares answered(map);
  for (std::size_t rule = 0; rule < tracks.rules.size(); ++rule) {
    const TrackRule& of = tracks.rules[rule];
    if (!is_judged_at(of, limit_m)) continue;
    const TrackScore score = score_track(tracks, rule, limit_m);
    if (of.is_static()) {
      figures.constants.push_back(
          {to_text(of.look), score.coverage, score.time_ratio, score.work_ratio, score.lost_count});
      continue;
    }
    const AnswerKind kind = kind_of(of.choice);
    for (std::size_t i = 0; i < tracks.scans.size(); ++i) {
      const TrackedScan& scan = tracks.scans[i];
      answered.add_scan(kind, limit_m, {scan.p_x_map_m, scan.p_y_map_m},
                        tracks.step(rule, i).error_m);
    }
    figures.answers.push_back({kind, score.coverage, answered.share(kind, limit_m),
                               score.time_ratio, score.work_ratio, score.lost_count});
  }
  std::ranges::sort(figures.answers, {}, &AnswerScore::kind);
  return figures;
}

void add_looks(const CompiledMap& map, const LookEvaluation& looks, std::size_t limit,
               LimitFigures& figures) {
  for (const StaticLook& look : looks.statics) {
    figures.constants.push_back(
        {to_text(look.look), look.coverage[limit], look.time_ratio, look.work_ratio, {}});
  }
  if (!map.looks) return;
  const LookRuleScore& score = looks.score(limit, LookRule::kMap);
  figures.answers.push_back({AnswerKind::kLook,
                             score.coverage,
                             answered_coverage_of_looks(map, limit, score.coverage),
                             score.time_ratio,
                             score.work_ratio,
                             {}});
}

// Of a drive that was not replayed.
LimitFigures figures_at(const CompiledMap& map, const Evaluation& evaluation, std::size_t limit) {
  LimitFigures figures;
  figures.limit_m = evaluation.limits_m[limit];
  if (evaluation.samples) {
    add_looks(map, *evaluation.samples, limit, figures);
  } else {
    for (const Rule rule : {Rule::kStaticEqualCoverage, Rule::kStaticLongest}) {
      const RuleScore& score = evaluation.score(limit, rule);
      figures.constants.push_back({fixed(score.mean_range_m, 0) + " m",
                                   score.coverage,
                                   score.time_ratio,
                                   score.work_ratio,
                                   {}});
    }
  }
  AnsweredShares answered(map);
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    const std::size_t range = evaluation.chosen(limit, Rule::kMap, i);
    answered.add_site(AnswerKind::kRange, figures.limit_m, evaluation.sites[i].site,
                      evaluation.error_m[i * evaluation.statics.size() + range]);
  }
  const RuleScore& score = evaluation.score(limit, Rule::kMap);
  figures.answers.push_back({AnswerKind::kRange,
                             score.coverage,
                             answered.share(AnswerKind::kRange, figures.limit_m),
                             score.time_ratio,
                             score.work_ratio,
                             {}});
  std::ranges::sort(figures.answers, {}, &AnswerScore::kind);
  return figures;
}

std::uint32_t lost(const auto& score) { return score.lost_count.value_or(0); }

// The better one is less.
std::tuple<double, std::uint32_t, double> worth(const ConstantScore& score) {
  return {-score.coverage, lost(score), score.work_ratio};
}

}  // namespace

EvaluationFigures figures_of(const CompiledMap& map, const Evaluation& evaluation,
                             const DriveTracks* tracks) {
  EvaluationFigures figures;
  figures.drive = evaluation.drive;
  figures.is_simulated = evaluation.reference == ErrorReference::kSimulated;
  figures.site_count = evaluation.site_count;
  figures.judged_count = static_cast<std::uint32_t>(evaluation.sites.size());
  if (tracks != nullptr) figures.scan_count = static_cast<std::uint32_t>(tracks->scans.size());
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    figures.limits.push_back(tracks != nullptr
                                 ? figures_at(map, *tracks, evaluation.limits_m[limit])
                                 : figures_at(map, evaluation, limit));
  }
  return figures;
}

const ConstantScore* best_constant(const LimitFigures& figures, const AnswerScore& answer) {
  const ConstantScore* cheapest = nullptr;
  const ConstantScore* most = nullptr;
  for (const ConstantScore& score : figures.constants) {
    const bool is_as_good = score.coverage >= answer.coverage && lost(score) <= lost(answer);
    if (is_as_good && (cheapest == nullptr || score.work_ratio < cheapest->work_ratio)) {
      cheapest = &score;
    }
    if (most == nullptr || worth(score) < worth(*most)) most = &score;
  }
  return cheapest != nullptr ? cheapest : most;
}

const ConstantScore* best_constant_within(const LimitFigures& figures, double most_work_ratio) {
  const ConstantScore* best = nullptr;
  for (const ConstantScore& score : figures.constants) {
    if (score.work_ratio > most_work_ratio) continue;
    if (best == nullptr || worth(score) < worth(*best)) best = &score;
  }
  return best;
}

}  // namespace sightline
