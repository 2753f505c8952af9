#include "passes/model/promise/promise_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// Blocks below these see the same walls (schemas/definitions.md, "Error model and choice of
// range"), and figures measured on them give no promise.
constexpr double kIndependentBlock_m = 60.0;
constexpr double kIndependentBuffer_m = 25.0;

// Blocks of one place are more alike than blocks of two, so up to so many places the bound of
// exchangeable blocks is optimistic: 5.1 to 5.9 % were measured where 5 % was named.
constexpr std::uint32_t kFewPlaces = 3;

// By NoPromise.
constexpr std::array<const char*, 5> kWithdrawn = {
    "the model was trained on one place, and these sites are in another; train it on two places or "
    "more",
    "sites are unlike the training data; train the model on similar places with a similar sensor",
    "a cheaper answer is sufficient on the drives that were measured here",
    "the answer for a tighter limit, chosen by the map's own scans, is shorter than the model's",
    "this map was made without scans, and the model was trained on maps made from scans; train it "
    "on finished maps (map: instead of mapping:) with drives through them"};

constexpr const char* kContradicted = "No promise: the errors measured in this map contradict it";

// Three digits: "5 %", "99.5 %".
std::string short_percent(double share) { return fmt::format("{:.3g} %", 100.0 * share); }

std::string kilometres(double hectometres) { return fixed(hectometres / 10.0, 1) + " km"; }

std::string counted(std::uint32_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string counted_drives(std::uint32_t count) {
  return count == 1 ? "one drive" : counted(count, "drive");
}

std::string limit_of(const LimitPromise& promise) { return format_double(promise.limit_m) + " m"; }

// "3.1 % of the answered sites missed 0.1 m and 12 % of the sites had no answer (cross-validated on
// 70 blocks of 7 places, 14 drives"
std::string observed_misses(const LimitPromise& promise) {
  return concat(short_percent(promise.calibration_miss_share), " of the answered sites missed ",
                limit_of(promise), " and ", short_percent(1.0 - promise.answered_share),
                " of the sites had no answer (cross-validated on ",
                counted(promise.block_count, "block"), " of ",
                counted(promise.place_count, "place"), ", ", counted(promise.drive_count, "drive"));
}

bool is_conformal(const LimitPromise& promise) {
  return promise.method == risk_control_name(RiskControl::kConformal);
}

// "at most 5 % of `whom` are expected to miss 0.1 m (conformal risk control)"
std::string bound_text(const LimitPromise& promise, const std::string& whom) {
  const std::string share = short_percent(promise.alpha);
  if (is_conformal(promise)) {
    return "at most " + share + " of " + whom + " are expected to miss " + limit_of(promise) +
           " (conformal risk control)";
  }
  return "with " + short_percent(1.0 - promise.delta) + " confidence at most " + share + " of " +
         whom + " miss " + limit_of(promise) + " (learn then test)";
}

// The share of answered sites that may miss in a calibration of so many blocks, for alpha at the
// next drive: (misses + 1) / (answered + 1) <= alpha, in blocks (risk_control.h). 0 where none may.
double allowed_misses(const LimitPromise& promise) {
  const double answered_blocks = promise.block_count * promise.answered_share;
  if (answered_blocks <= 0.0) return 0.0;
  return std::max(0.0, promise.alpha - (1.0 - promise.alpha) / answered_blocks);
}

// "40 blocks allow 2.63 % for a promise of 5 %"
std::string price_of_few_blocks(const LimitPromise& promise) {
  return concat(
      counted(promise.block_count, "block"), promise.block_count == 1 ? " allows " : " allow ",
      short_percent(allowed_misses(promise)), " for a promise of ", short_percent(promise.alpha));
}

bool is_simulated(const TrainingCard& card) { return card.reference == ErrorReference::kSimulated; }

// Why a threshold that was set on this drive may not suit the next.
std::string why_this_drive(const LimitPromise& promise, const TrainingCard& card) {
  if (is_simulated(card)) return "no drive was recorded here, so the errors are simulated";
  if (promise.drive_count <= 1) return "only one drive was measured";
  if (card.hold_out == "blocks") return "the model was trained on the drives that were measured";
  return "fewer than two measured drives neither made the map nor trained the model";
}

// To a decimetre: blocks share the route evenly.
std::string metres(double length_m) {
  return format_double(std::round(10.0 * length_m) / 10.0) + " m";
}

// "it needs 1.2 km of measured route; so far there are 0.6 km from one drive"
std::string needed_route(const LimitPromise& promise, double block_m, std::uint32_t needed_blocks) {
  const std::string whom = promise.scope == PromiseScope::kThisDrive
                               ? "route measured by two or more drives that the model was not "
                                 "trained on"
                               : "measured route";
  return concat("it needs ", kilometres(std::ceil(needed_blocks * block_m / 100.0)), " of ", whom,
                "; so far there are ",
                kilometres(std::floor(promise.block_count * block_m / 100.0)), " from ",
                counted_drives(promise.drive_count));
}

// What a promise needs, without the fallback.
std::string what_is_needed(const LimitPromise& promise, const TrainingCard& card,
                           std::uint32_t needed_blocks) {
  if (is_simulated(card)) return "the errors are simulated; it needs drives through this map";
  if (!are_poses_known(card)) {
    return "errors were measured against matches to the map itself; it needs known poses "
           "(measure-error.reference=known)";
  }
  if (!are_blocks_independent(card)) {
    return "blocks of " + metres(card.block_m) + " with a buffer of " + metres(card.buffer_m) +
           " see the same walls; it needs blocks of 60 m and a buffer of 25 m";
  }
  if (promise.block_count < needed_blocks) {
    return needed_route(promise, card.block_m, needed_blocks);
  }
  const std::string text = "at every threshold too many of the answered sites miss " +
                           limit_of(promise) + " for " + short_percent(promise.alpha);
  return is_conformal(promise) ? text + "; " + price_of_few_blocks(promise) : text;
}

// "121 m of route, a promise needs 1.2 km"; nothing where there is enough.
std::string missing_route(const StaticAnswers& answers) {
  if (answers.route_m >= answers.needed_route_m) return "";
  return concat(fixed(answers.route_m, 0), " m of route, a promise needs ",
                kilometres(std::ceil(answers.needed_route_m / 100.0)));
}

std::string why_static(const StaticAnswers& answers) {
  const std::string missing = missing_route(answers);
  if (answers.reason == Reason::kTooShort) {
    return concat("the drive is too short to train on",
                  missing.empty() ? "" : " (" + missing + ")");
  }
  if (answers.reason == Reason::kExplainsNothing) {
    return concat("the model cannot distinguish the places (cross-validated R^2 ",
                  fixed(answers.explained, 2), missing.empty() ? "" : "; " + missing, ")");
  }
  return answers.reason == Reason::kCheaper
             ? "the model's choice takes more time and covers no more sites"
             : "no drive was recorded here, and no model of other drives was given";
}

}  // namespace

bool are_poses_known(const TrainingCard& card) {
  return card.reference == ErrorReference::kKnownPose;
}

bool are_blocks_independent(const TrainingCard& card) {
  return card.block_m >= kIndependentBlock_m && card.buffer_m >= kIndependentBuffer_m;
}

std::string earned_statement(const LimitPromise& promise, double worst_place_miss_share) {
  const std::string whom = promise.place_count > 1 ? "the answered sites in places like these"
                                                   : "this place's answered sites";
  std::string text =
      "On the next drive " + bound_text(promise, whom) + "; so far " + observed_misses(promise);
  if (is_conformal(promise)) text += "; " + price_of_few_blocks(promise);
  if (promise.place_count > 1) {
    text += "; " + short_percent(worst_place_miss_share) + " in the worst place";
  }
  if (promise.place_count > kFewPlaces) return text + ")";
  return text +
         "); with 1 to 3 places the bound is slightly optimistic: 5.1 to 5.9 % missed where 5 % "
         "was allowed";
}

std::string generated_statement(const LimitPromise& promise) {
  const std::string predicted =
      "Predicted from generated worlds: no promise for recorded drives (`sightline train` makes a "
      "model of such drives)";
  if (!promise.is_earned) return predicted + ". " + promise.statement;
  return predicted + ". Over generated worlds: " + promise.statement;
}

std::string this_drive_statement(const LimitPromise& promise, const TrainingCard& card) {
  return "No promise for the next drive: " + why_this_drive(promise, card) +
         (is_simulated(card) ? "; of the simulated scans " : "; on this drive ") +
         bound_text(promise, is_simulated(card) ? "the answered sites" : "its answered sites") +
         "; " + observed_misses(promise) + ")";
}

std::string mean_rule_statement(const LimitPromise& promise) {
  return "No promise: a mean error within the limit does not bound the share of misses; " +
         observed_misses(promise) + ")";
}

std::string joined_statement(const LimitPromise& map_only, const LimitPromise& history) {
  return "Places with measured drives: " + history.statement +
         "; places without: " + map_only.statement;
}

std::string groups_statement(const LimitPromise& constrained, const LimitPromise& weak) {
  return "Outside tunnels, corridors, open roads, fields and halls: " + constrained.statement +
         "; in these: " + weak.statement;
}

std::string to_text(const StaticAnswers& answers, double limit_m) {
  const std::string kind = takes_every_return(answers.cheapest) ? "range" : "look";
  const std::string from = to_text(answers.cheapest);
  const std::string taken =
      answers.cheapest == answers.dearest
          ? concat("one ", kind, " is used for the whole map: ", from)
          : concat(kind, "s from ", from, " to ", to_text(answers.dearest), " are used, by site");
  return concat("No promise: ", why_static(answers), ", so ", taken, "; ",
                answers.is_simulated ? "twice the simulated error" : "the measured error",
                " is within ", format_double(limit_m), " m at ", percent(answers.coverage),
                " of the sites");
}

std::string withdrawn_statement(NoPromise why, std::size_t unlike_count, std::size_t site_count) {
  const std::string text = kWithdrawn.at(static_cast<std::size_t>(why));
  if (why != NoPromise::kUnlike) return "No promise: " + text;
  return fmt::format("No promise: {} of {} {}", unlike_count, site_count, text);
}

std::string contradicted_statement(const LimitPromise& promise, double share_within,
                                   std::uint32_t missed_blocks, std::uint32_t block_count) {
  return fmt::format(
      "{}: {} of the answered sites are within {}, the model's promise was {} (misses of {} in {}; "
      "by chance in less than one of 100 maps)",
      kContradicted, percent(share_within), limit_of(promise), short_percent(1.0 - promise.alpha),
      counted(missed_blocks, "block"), counted(block_count, "block"));
}

bool is_contradicted(const LimitPromise& promise) {
  return promise.statement.starts_with(kContradicted);
}

std::string drives_text(std::size_t drive_count, double coverage, double limit_m) {
  return fmt::format(
      "; cross-validated over the {} drives here, {} of the answered sites are within {} m",
      drive_count, percent(coverage), format_double(limit_m));
}

std::string unearned_statement(const LimitPromise& promise,
                               const CalibrationDrives& calibration_drives,
                               const RiskDecision& decision) {
  const TrainingCard& card = calibration_drives.model.card;
  const bool is_given = promise.method == risk_control_name(RiskControl::kFixed);
  if (is_given || promise.method == risk_control_name(RiskControl::kEmpirical)) {
    return concat("No promise: the threshold ",
                  is_given ? "was given" : "is fitted to the measured sites",
                  " (risk_control=", promise.method, "); ", observed_misses(promise), ")");
  }
  const double least_m = least_error_m(calibration_drives);
  if (promise.block_count > 0 && least_m > promise.limit_m) {
    return "No promise: no range reached " + limit_of(promise) +
           " anywhere; the least measured error is " + format_double(least_m) + " m";
  }
  const std::string needed = what_is_needed(promise, card, decision.needed_blocks);
  return "No promise yet: " + needed + "; " + observed_misses(promise) +
         ", with a threshold fitted to them)";
}

}  // namespace sightline
