#include "compiler/views/verdict/verdict_sentences.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "formats/text/numbers.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

std::string in_words(double limit_m) {
  return limit_m < 1.0 ? format_double(std::round(1e6 * limit_m) / 1e4) + " cm"
                       : format_double(limit_m) + " m";
}

// "The map's plan keeps ...", "the map's looks keep ...".
std::string subject(AnswerKind kind) {
  return kind == AnswerKind::kPlan ? "plan" : std::string(name_of(kind)) + "s";
}

std::string tracks_text(std::uint32_t count) {
  return concat(count, count == 1 ? " track" : " tracks");
}

// "27 % of the work", "4.4 times the work".
std::string work_text(double ratio) {
  if (ratio < 1.0) return fmt::format("{:.0f} % of the work", 100.0 * ratio);
  return fmt::format("{} times the work", fixed(ratio, ratio < 1.95 ? 2 : 1));
}

// "keeps 97.9 % and loses 3 tracks": lost tracks where they are more than those of `score`.
std::string kept_by(const ConstantScore& constant, const AnswerScore& score) {
  const std::uint32_t lost = constant.lost_count.value_or(0);
  const std::string text = "keeps " + percent(constant.coverage);
  return lost > score.lost_count.value_or(0) ? concat(text, " and loses ", tracks_text(lost))
                                             : text;
}

// "with 27 % of the work (points times iterations) of the best fixed choice (which keeps 97.9 % and
// loses 3 tracks); a fixed choice of the same work keeps 90.1 %"
std::string compared(const LimitVerdict& limit) {
  const AnswerScore& score = *limit.score;
  const ConstantScore& constant = *limit.constant;
  if (constant.work_ratio <= 0.0) return "";
  const double ratio = score.work_ratio / constant.work_ratio;
  std::string text = ratio > 0.95 && ratio < 1.05
                         ? ", with the same work (points times iterations) as the best fixed choice"
                         : concat(", with ", work_text(ratio),
                                  " (points times iterations) of the best fixed choice");
  const bool keeps_less = constant.coverage < score.coverage - 1e-9;
  const bool loses_more = constant.lost_count.value_or(0) > score.lost_count.value_or(0);
  if (keeps_less || loses_more) text += concat(" (which ", kept_by(constant, score), ")");
  if (!limit.same_work || *limit.same_work == constant) return text;
  return concat(text, "; a fixed choice of the same work ", kept_by(*limit.same_work, score));
}

// Which kind answers is written where the recommended one answers fewer places than all together.
std::string answered_words(const LimitVerdict& limit) {
  const std::string all = percent(limit.answered_share);
  const std::string own = percent(limit.recommended_share);
  const char* const kind = limit.recommended == AnswerKind::kRange ? "range" : "look";
  const std::string by_kind = all == own ? "" : concat(" (", own, " by a ", kind, ")");
  return concat(all, " of the places are answered", by_kind);
}

std::string predicted_words(const LimitVerdict& limit) {
  const bool is_range = limit.recommended == AnswerKind::kRange;
  return fmt::format(
      "No drive has judged this map; its {} are predicted to keep {} of the places within {}, and "
      "{}",
      is_range ? "ranges" : "looks", percent(limit.expected_coverage), in_words(limit.limit_m),
      answered_words(limit));
}

bool is_known(const std::string& config) { return config != VerdictFiles().config; }

// With its configuration the page shows the street too.
std::string page_command(const VerdictFiles& files) {
  const std::string map = command_word(files.map);
  return is_known(files.config) ? concat("sightline report ", command_word(files.config), " --map ",
                                         map, " -o map.html  # ")
                                : concat("sightline report ", map, " -o map.html  # ");
}

// How to judge the map by a drive that it was not made from.
std::string judging_command(const MapJudgement& judgement, const VerdictFiles& files) {
  const std::string map = command_word(files.map);
  const std::string config = command_word(files.config);
  const std::string command = concat("sightline evaluate ", config, " --map ", map, "  # ");
  const bool is_judged = judgement.evidence == Evidence::kEvaluation;
  if (!files.names_evaluation && judgement.has_other_scans && !is_judged) {
    return command + "judges the map by the scans of its drive that did not make it";
  }
  if (!files.names_evaluation) {
    return concat(page_command(files), "shows the map; to judge it, name another drive under ",
                  "evaluation: in ", config);
  }
  if (is_judged) {
    return concat(
        "sightline init RECORDING -o other.yaml  # describes another drive; name it under ",
        "evaluation: in ", config);
  }
  if (is_known(files.config)) return command + "judges the map by another drive";
  return command + (judgement.has_other_scans
                        ? "judges it by evaluation: in CONFIG or its own other scans"
                        : "judges the map by the drive under evaluation: in CONFIG");
}

// Makes a map of the fixed choice alone, which is a range ("15 m") or a look ("50 m, 64 points").
std::string fixed_command(const std::string& look, const VerdictFiles& files) {
  const std::string range_m = look.substr(0, look.find(' '));
  const bool is_range = look == range_m + " m";
  return concat("sightline compile ", command_word(files.config), " -o fixed.slmap --set ",
                is_range ? "annotation.looks=paper --set annotation.ranges_m=" + range_m
                         : "annotation.looks=" + command_word(look),
                "  # makes a map of that fixed choice");
}

}  // namespace

std::string why_missed(const AnswerScore& score, const std::optional<ConstantScore>& constant,
                       const LimitVerdict& verdict) {
  const std::uint32_t lost = score.lost_count.value_or(0);
  const std::uint32_t least = constant ? constant->lost_count.value_or(0) : lost;
  if (lost > least) {
    return fmt::format("The map's {} lost {}, the best fixed choice {}", subject(score.kind),
                       tracks_text(lost), least);
  }
  return fmt::format("Where the map's {} {} an answer, {} is within {}, the target is {}",
                     subject(score.kind), score.kind == AnswerKind::kPlan ? "has" : "have",
                     percent(score.answered_coverage), in_words(verdict.limit_m),
                     percent(verdict.target));
}

std::string reaching(AnswerKind kind) {
  return concat("its ", subject(kind), kind == AnswerKind::kPlan ? " reaches" : " reach",
                " the target");
}

std::string why_more_work(const LimitVerdict& verdict) {
  return fmt::format("A fixed choice needs less work here: use {} everywhere ({})",
                     verdict.constant->look,
                     work_text(verdict.constant->work_ratio / verdict.score->work_ratio));
}

std::string why_unanswered(const LimitVerdict& verdict) {
  std::string text = fmt::format("No {} keeps {} at {} of the places",
                                 verdict.has_looks ? "look or range" : "range",
                                 in_words(verdict.limit_m), percent(1.0 - verdict.answered_share));
  if (verdict.unmet_m <= 0.0) return text;
  return text + fmt::format(" (longest stretch {} m, from place {})", fixed(verdict.unmet_m, 0),
                            verdict.unmet_site);
}

std::string why_assumed(const std::vector<UnconstrainedStretch>& stretches) {
  double way_m = 0.0;
  for (const UnconstrainedStretch& stretch : stretches) way_m += stretch.way_m;
  const UnconstrainedStretch& longest =
      *std::ranges::max_element(stretches, {}, &UnconstrainedStretch::way_m);
  return fmt::format(
      "On {} m of the way the scans do not constrain the poses of the map{}: {} (scans {} to {})",
      fixed(way_m, 0), stretches.size() > 1 ? ", most" : "", substitute_text(longest),
      longest.first_scan, longest.last_scan);
}

namespace {

std::string drive_text(const MapJudgement& judgement) {
  const std::string drive = "drive " + judgement.drive;
  if (judgement.origin == DriveOrigin::kOtherScans) {
    return "its own drive (same drive, other scans: optimistic)";
  }
  if (judgement.origin == DriveOrigin::kKnown) return drive + " (known drive: optimistic)";
  if (judgement.origin == DriveOrigin::kUnknown) return drive + " (origin unknown)";
  return judgement.is_own_drive ? "its own drive (optimistic)" : drive;
}

}  // namespace

std::string figures_sentence(const MapJudgement& judgement, const LimitVerdict& limit) {
  if (!limit.score) return predicted_words(limit);
  const AnswerScore& score = *limit.score;
  std::string text = fmt::format(
      "On {} the map's {} {} {} of {} {} within {}", drive_text(judgement), subject(score.kind),
      score.kind == AnswerKind::kPlan ? "keeps" : "keep", percent(score.coverage),
      judgement.judged_count, judgement.is_replayed ? "scans" : "places", in_words(limit.limit_m));
  if (score.lost_count) {
    const std::uint32_t lost = *score.lost_count;
    text += lost == 0 ? " and no track is lost"
                      : concat(" and ", tracks_text(lost), lost == 1 ? " is lost" : " are lost");
  }
  if (limit.constant) text += compared(limit);
  if (score.kind != limit.recommended)
    text += "; its " + subject(limit.recommended) + " is judged by `evaluate`";
  const bool is_in_reason = limit.reason == why_unanswered(limit) &&
                            percent(limit.answered_share) == percent(limit.recommended_share);
  return is_in_reason ? text : text + "; " + answered_words(limit);
}

std::string as_sentence(std::string text) {
  if (text.empty()) return text;
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text.back() == '.' ? text : text + ".";
}

std::string listing_command(const VerdictFiles& files, const std::string& what_it_does) {
  return concat("sightline inspect ", command_word(files.map), " --all  # ", what_it_does);
}

std::string next_command(const MapJudgement& judgement, const VerdictFiles& files) {
  const std::string map = command_word(files.map);
  if (judgement.verdict == MapVerdict::kBad) {
    return concat("sightline weak ", map, "  # shows where the map is weak, and why");
  }
  if (judgement.evidence != Evidence::kEvaluation || judgement.is_own_drive) {
    return judging_command(judgement, files);
  }
  const LimitVerdict& limit = judgement.limits[judgement.deciding];
  if (limit.constant && limit.reason.ends_with(why_more_work(limit))) {
    return fixed_command(limit.constant->look, files);
  }
  if (judgement.verdict == MapVerdict::kPartly) {
    return concat("sightline weak ", map, "  # shows where the map is weak, and why");
  }
  return page_command(files) + "shows the map as a page";
}

}  // namespace sightline
