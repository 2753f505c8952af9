#include "compiler/views/verdict/verdict.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "formats/text/numbers.h"
#include "formats/text/quoted_text.h"
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

std::string in_words(double limit_m) {
  return limit_m < 1.0 ? format_double(std::round(1e6 * limit_m) / 1e4) + " cm"
                       : format_double(limit_m) + " m";
}

// "The map's plan keeps ...", "the map's looks keep ...".
std::string subject(AnswerKind kind) {
  return kind == AnswerKind::kPlan ? "plan" : std::string(name_of(kind)) + "s";
}

// Sets the longest stretch of neighbouring sites without an answer that is good enough.
void find_unmet(const CompiledMap& map, std::size_t limit, LimitVerdict& verdict) {
  const RangeTable& table = table_of(map, verdict.recommended);
  const std::vector<Site>& sites = map.sites.sites;
  std::optional<std::size_t> begin;
  for (std::size_t site = 0; site < sites.size(); ++site) {
    const bool is_unmet = (table.flags_of(site, limit) & kUnmet) != 0;
    if (!is_unmet || (begin && sites[site].run != sites[*begin].run)) begin.reset();
    if (!is_unmet) continue;
    if (!begin) begin = site;
    const double length_m = sites[site].s_m - sites[*begin].s_m;
    if (length_m <= verdict.unmet_m) continue;
    verdict.unmet_m = length_m;
    verdict.unmet_site = *begin;
  }
}

// What the map has of its localization drive: no replay, so neither a plan nor lost tracks nor
// times.
std::optional<AnswerScore> own_score(const CompiledMap& map, AnswerKind kind, std::size_t limit) {
  if (kind == AnswerKind::kPlan) return std::nullopt;
  const LimitQuality& quality = quality_of(map, kind, limit);
  const std::size_t sites = map.sites.sites.size();
  const double answered = 1.0 - share_of(quality.unmet_count, sites);
  const double coverage = quality.measured_coverage;
  return AnswerScore{kind, coverage, answered > 0.0 ? std::min(1.0, coverage / answered) : 1.0, 0.0,
                     std::nullopt};
}

const AnswerScore* find_score(const LimitFigures& figures, AnswerKind kind) {
  const auto found = std::ranges::find(figures.answers, kind, &AnswerScore::kind);
  return found == figures.answers.end() ? nullptr : &*found;
}

// One kind of answer against the target.
struct Trial {
  AnswerScore score;
  std::optional<ConstantScore> constant;

  [[nodiscard]] bool loses_more() const {
    return constant && score.lost_count.value_or(0) > constant->lost_count.value_or(0);
  }
  [[nodiscard]] bool reaches(double target) const {
    return score.answered_coverage >= target - kSlack && !loses_more();
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
      if (score) trials.push_back({*score, std::nullopt});
    }
    if (evidence != Evidence::kEvaluation) continue;
    const LimitFigures& figures = evaluation->limits[limit];
    const AnswerScore* const score = find_score(figures, kind);
    if (score == nullptr) continue;
    const ConstantScore* const constant = best_constant(figures, *score);
    trials.push_back({*score, constant != nullptr ? std::optional(*constant) : std::nullopt});
  }
  return trials;
}

std::string why_missed(const Trial& trial, const LimitVerdict& verdict) {
  if (trial.loses_more()) {
    return fmt::format("The map's {} lost {} tracks, the best fixed choice {}",
                       subject(trial.score.kind), *trial.score.lost_count,
                       trial.constant->lost_count.value_or(0));
  }
  return fmt::format("Where the map has an answer, {} is within {}, the target is {}",
                     percent(trial.score.answered_coverage), in_words(verdict.limit_m),
                     percent(verdict.target));
}

// Sets verdict, recommended answer and reason by what was measured.
void judge_trials(const std::vector<Trial>& trials, LimitVerdict& verdict) {
  const auto reaches = [&](const Trial& trial) { return trial.reaches(verdict.target); };
  const auto found = std::ranges::find_if(trials, reaches);
  const Trial& taken = found == trials.end() ? trials.front() : *found;
  verdict.score = taken.score;
  verdict.constant = taken.constant;
  if (found == trials.begin()) {
    verdict.verdict = MapVerdict::kGood;
    return;
  }
  verdict.reason = why_missed(trials.front(), verdict);
  if (found != trials.end()) {
    verdict.verdict = MapVerdict::kPartly;
    verdict.recommended = taken.score.kind;
    verdict.reason += concat("; its ", subject(taken.score.kind), " reach the target");
    return;
  }
  verdict.verdict = taken.is_bad(verdict.target) ? MapVerdict::kBad : MapVerdict::kPartly;
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

std::string why_unanswered(const LimitVerdict& verdict) {
  const std::string share = percent(1.0 - verdict.answered_share);
  if (verdict.unmet_m <= 0.0) {
    return fmt::format("No answer is good enough for {} at {} of the places",
                       in_words(verdict.limit_m), share);
  }
  return fmt::format(
      "No answer is good enough for {} at {} of the places (longest stretch {} m, "
      "from site {})",
      in_words(verdict.limit_m), share, fixed(verdict.unmet_m, 0), verdict.unmet_site);
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
  verdict.answered_share = 1.0 - share_of(quality.unmet_count, map.sites.sites.size());
  verdict.expected_coverage = quality.expected_coverage;
  find_unmet(map, limit, verdict);
  if (!is_answered(verdict)) lower(MapVerdict::kPartly, why_unanswered(verdict), verdict);
  const double judged = judged_share(map, evaluation, evidence);
  if (judged < Thresholds::kLeastJudged - kSlack) {
    lower(MapVerdict::kPartly, fmt::format("Only {} of the sites were judged", percent(judged)),
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

// "in 27 % of the time of the best fixed choice (97.9 % within 10 cm, 3 tracks lost)"
std::string compared(const AnswerScore& score, const ConstantScore& constant) {
  if (constant.time_ratio <= 0.0) return "";
  std::string text = fmt::format(", in {:.0f} % of the time of the best fixed choice",
                                 100.0 * score.time_ratio / constant.time_ratio);
  const bool keeps_less = constant.coverage < score.coverage - kSlack;
  const bool loses_more = constant.lost_count.value_or(0) > score.lost_count.value_or(0);
  if (keeps_less || loses_more) text += fmt::format(" (which keeps {}", percent(constant.coverage));
  if (loses_more) text += fmt::format(" and loses {} tracks", *constant.lost_count);
  return keeps_less || loses_more ? text + ")" : text;
}

std::string answered_words(const LimitVerdict& limit) {
  return percent(limit.answered_share) + " of the places are answered";
}

std::string figures_text(const MapJudgement& judgement, const LimitVerdict& limit) {
  if (!limit.score) {
    return fmt::format("No drive has judged this map; it predicts {} within {}, and {}",
                       percent(limit.expected_coverage), in_words(limit.limit_m),
                       answered_words(limit));
  }
  const AnswerScore& score = *limit.score;
  const bool is_own = judgement.evidence == Evidence::kOwnDrive;
  std::string text = fmt::format(
      "On {} {} the map's {} {} {} of {} {} within {}", is_own ? "its own drive" : "drive",
      is_own ? "(optimistic)" : judgement.drive, subject(score.kind),
      score.kind == AnswerKind::kPlan ? "keeps" : "keep", percent(score.coverage),
      judgement.judged_count, judgement.is_replayed ? "scans" : "sites", in_words(limit.limit_m));
  if (score.lost_count) {
    text += *score.lost_count == 0 ? " and no track is lost"
                                   : fmt::format(" and {} tracks are lost", *score.lost_count);
  }
  if (limit.constant) text += compared(score, *limit.constant);
  return limit.reason.starts_with("No answer") ? text : text + "; " + answered_words(limit);
}

std::string as_sentence(std::string text) {
  if (text.empty()) return text;
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text.back() == '.' ? text : text + ".";
}

std::string promise_of(const CompiledMap& map, const LimitVerdict& limit, std::size_t index) {
  const RangeTable& table = table_of(map, limit.recommended);
  return as_sentence(table.promises[index].statement);
}

// A word of a command line: quoted where a shell would split or expand it.
std::string word(const std::string& text) {
  const bool is_plain = std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("/-._~+,:@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  return is_plain && !text.empty() ? text : shell_word(text);
}

std::string next_of(const MapJudgement& judgement, bool is_in_pieces, const VerdictFiles& files) {
  const std::string map = word(files.map);
  if (is_in_pieces) return concat("sightline inspect ", map, " --all  # lists the pieces");
  if (judgement.verdict == MapVerdict::kBad) {
    return concat("sightline weak ", map, "  # shows where the map is weak, and why");
  }
  if (judgement.evidence != Evidence::kEvaluation) {
    return concat("sightline evaluate ", word(files.config), " --map ", map,
                  "  # judges the map by another drive");
  }
  if (judgement.verdict == MapVerdict::kPartly) {
    return concat("sightline weak ", map, "  # shows where the map is weak, and why");
  }
  return concat("sightline report ", map, " -o map.html  # shows the map as a page");
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

}  // namespace

std::string_view word_of(MapVerdict verdict) {
  static constexpr std::string_view kWords[] = {"good", "partly", "bad", "not judged"};
  return kWords[static_cast<std::size_t>(verdict)];
}

std::string_view colour_of(MapVerdict verdict) {
  static constexpr std::string_view kColours[] = {"green", "yellow", "red", "grey"};
  return kColours[static_cast<std::size_t>(verdict)];
}

MapJudgement judge_map(const CompiledMap& map, const EvaluationFigures* evaluation,
                       const VerdictFiles& files) {
  MapJudgement judgement;
  judgement.evidence = evidence_of(map, evaluation);
  const bool is_evaluated = judgement.evidence == Evidence::kEvaluation;
  judgement.drive = is_evaluated ? evaluation->drive : map.measurement.localization_drive;
  judgement.is_replayed = is_evaluated && evaluation->scan_count > 0;
  judgement.judged_count = !is_evaluated           ? map.measurement.measured_site_count
                           : judgement.is_replayed ? evaluation->scan_count
                                                   : evaluation->judged_count;
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    judgement.limits.push_back(judge_limit(map, evaluation, judgement.evidence, limit));
  }
  if (!judgement.limits.empty()) {
    decide(judgement);
    const LimitVerdict& limit = judgement.limits[judgement.deciding];
    judgement.figures = as_sentence(figures_text(judgement, limit));
    judgement.promise = promise_of(map, limit, judgement.deciding);
  }
  const std::size_t pieces = map.trajectory ? map.trajectory->pieces.size() : 0;
  if (pieces > 1) {
    judgement.verdict = MapVerdict::kBad;
    judgement.reason = fmt::format(
        "The trajectory has {} pieces that are not connected: their relative position is unknown.",
        pieces);
  }
  judgement.next = next_of(judgement, pieces > 1, files);
  return judgement;
}

}  // namespace sightline
