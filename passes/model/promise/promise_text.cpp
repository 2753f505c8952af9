#include "passes/model/promise/promise_text.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// Blocks below these see the same walls (schemas/definitions.md, "Error model and choice of
// range"), and what they witness is no promise.
constexpr double kIndependentBlock_m = 60.0;
constexpr double kIndependentBuffer_m = 25.0;

// Blocks of one place are more alike than blocks of two, so up to so many places the bound of
// exchangeable blocks is optimistic: 5.1 to 5.9 % were measured where 5 % was named.
constexpr std::uint32_t kFewPlaces = 3;

// By NoPromise.
constexpr std::array<const char*, 5> kWithdrawn = {
    "the model learnt from one place alone, and these sites lie in another; train it on two or "
    "more",
    "sites are unlike all that the model learnt from; train it on places, and with a sensor, like "
    "these",
    "another answer is cheaper and proven here",
    "what is enough for a tighter limit by the map's own scans is less than what the model would "
    "promise",
    "no scan made this map, and the model learnt from maps that scans made; train it on finished "
    "maps (map: in place of mapping:) with drives through them"};

// Three digits: "5 %", "99.5 %".
std::string short_percent(double share) { return fmt::format("{:.3g} %", 100.0 * share); }

std::string kilometres(double length_m) {
  return fixed(std::ceil(length_m / 100.0) / 10.0, 1) + " km";
}

std::string counted(std::uint32_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

// "3.1 % missed out of fold in 70 blocks of 7 places, 14 drives"
std::string observed_misses(const LimitPromise& promise) {
  return concat(short_percent(promise.calibration_miss_share), " missed out of fold in ",
                counted(promise.block_count, "block"), " of ",
                counted(promise.place_count, "place"), ", ", counted(promise.drive_count, "drive"));
}

std::string method_text(const LimitPromise& promise) {
  return promise.method == risk_control_name(RiskControl::kConformal) ? "conformal risk control"
                                                                      : "learn then test";
}

// "at most 5 % of `whom` are expected to miss 0.1 m"
std::string bound_text(const LimitPromise& promise, const std::string& whom) {
  const std::string limit = format_double(promise.limit_m) + " m";
  const std::string share = short_percent(promise.alpha);
  if (promise.method == risk_control_name(RiskControl::kConformal)) {
    return "at most " + share + " of " + whom + " are expected to miss " + limit;
  }
  return "with " + short_percent(1.0 - promise.delta) + " confidence at most " + share + " of " +
         whom + " miss " + limit;
}

bool is_simulated(const TrainingCard& card) { return card.reference == ErrorReference::kSimulated; }

// Why a threshold of this drive is none of the next.
std::string why_this_drive(const LimitPromise& promise, const TrainingCard& card) {
  if (is_simulated(card)) return "no drive was here, errors are those of simulated scans";
  if (promise.drive_count <= 1) return "one drive alone was measured";
  if (card.hold_out == "blocks") return "the trees learnt from the drives that set the threshold";
  return "fewer than two drives were measured that neither made the map nor taught the trees";
}

// To a decimetre: blocks share the route evenly.
std::string metres(double length_m) {
  return format_double(std::round(10.0 * length_m) / 10.0) + " m";
}

// What is wanting for a promise, without the fallback.
std::string what_is_wanting(const LimitPromise& promise, const TrainingCard& card,
                            std::uint32_t needed_blocks) {
  if (is_simulated(card)) return "drives through this map can earn a promise";
  if (!are_poses_known(card)) {
    return "errors were measured against matches to the map itself, known poses "
           "(measure-error.reference=known) can earn a promise";
  }
  if (!are_blocks_independent(card)) {
    return "blocks of " + metres(card.block_m) + " with a buffer of " + metres(card.buffer_m) +
           " see the same walls, 60 m and 25 m are needed";
  }
  if (promise.block_count < needed_blocks) {
    const double missing_m = (needed_blocks - promise.block_count) * card.block_m;
    return counted(promise.block_count, "block") + " of " + metres(card.block_m) + " cannot earn " +
           short_percent(promise.alpha) + ", " + std::to_string(needed_blocks) + " can, " +
           kilometres(missing_m) + " more of measured route" +
           (promise.scope == PromiseScope::kThisDrive
                ? ", by drives that the trees do not learn from"
                : "");
  }
  return "even the strictest threshold misses " + format_double(promise.limit_m) +
         " m too often for " + short_percent(promise.alpha);
}

// `found`: the evidence.
std::string why_static(const StaticAnswers& answers, const std::string& found) {
  if (answers.reason == Reason::kTooShort) return "the drive is too short to learn from";
  if (answers.reason == Reason::kExplainsNothing) {
    return "the model explains nothing out of fold (R^2 " + fixed(answers.explained, 2) + ")";
  }
  return answers.reason == Reason::kCheaper
             ? "the model's own choice costs more and covers no more of " + found
             : "no drive was here, and no model from elsewhere judges what was simulated";
}

}  // namespace

bool are_poses_known(const TrainingCard& card) {
  return card.reference == ErrorReference::kKnownPose;
}

bool are_blocks_independent(const TrainingCard& card) {
  return card.block_m >= kIndependentBlock_m && card.buffer_m >= kIndependentBuffer_m;
}

std::string earned_statement(const LimitPromise& promise, double worst_place_miss_share) {
  const std::string whom = promise.place_count > 1 ? "places like these" : "this place's sites";
  std::string text = "on the next drive " + bound_text(promise, whom) + " (" +
                     method_text(promise) + "; " + observed_misses(promise);
  if (promise.place_count > 1) {
    text += ", " + short_percent(worst_place_miss_share) + " in the worst place";
  }
  if (promise.place_count > kFewPlaces) return text + ")";
  return text +
         "); blocks of so few places are alike, and the bound is a little optimistic: 5.1 to 5.9 % "
         "missed with 2 and 3 places where 5 % was named";
}

std::string this_drive_statement(const LimitPromise& promise, const TrainingCard& card) {
  return "nothing is promised about the next drive: " + why_this_drive(promise, card) +
         (is_simulated(card) ? "; of the simulated scans " : "; of this drive ") +
         bound_text(promise, is_simulated(card) ? "the sites" : "its sites") + " (" +
         method_text(promise) + "; " + observed_misses(promise) + ")";
}

std::string stricter_statement(const LimitPromise& promise,
                               const CalibrationDrives& calibration_drives, double stricter_alpha,
                               std::uint32_t needed_blocks) {
  LimitPromise stricter = promise;
  stricter.alpha = stricter_alpha;
  return "; " + short_percent(stricter_alpha) + " is not earned: " +
         what_is_wanting(stricter, calibration_drives.model.card, needed_blocks);
}

std::string mean_rule_statement(const LimitPromise& promise) {
  return "nothing is promised: a mean within the limit says little about misses; " +
         observed_misses(promise);
}

std::string joined_statement(const LimitPromise& map_only, const LimitPromise& history) {
  return "with measured history: " + history.statement + "; elsewhere: " + map_only.statement;
}

std::string to_text(const StaticAnswers& answers, double limit_m) {
  const std::string found = answers.is_simulated
                                ? "what was simulated here, each error taken twice,"
                                : "what was measured here";
  const std::string from = to_text(answers.cheapest);
  return "nothing is promised: " + why_static(answers, found) + "; " +
         (answers.cheapest == answers.dearest
              ? "everywhere it takes " + from
              : "it takes from " + from + " to " + to_text(answers.dearest) + ", by site") +
         ", where " + found + " is within " + format_double(limit_m) + " m at " +
         percent(answers.coverage) + " of the sites";
}

std::string withdrawn_statement(NoPromise why, std::size_t unlike_count, std::size_t site_count) {
  const std::string text = kWithdrawn.at(static_cast<std::size_t>(why));
  if (why != NoPromise::kUnlike) return "nothing is promised: " + text;
  return fmt::format("nothing is promised: {} of {} {}", unlike_count, site_count, text);
}

std::string drives_text(std::size_t drive_count, double coverage, double limit_m) {
  return fmt::format(
      "; of {} drives here, each left out in turn and predicted by the others, {} of the sites "
      "were within {} m at such answers",
      drive_count, percent(coverage), format_double(limit_m));
}

std::string unearned_statement(const LimitPromise& promise,
                               const CalibrationDrives& calibration_drives,
                               std::uint32_t needed_blocks) {
  const TrainingCard& card = calibration_drives.model.card;
  const std::string nothing = "nothing is promised: ";
  const bool is_given = promise.method == risk_control_name(RiskControl::kFixed);
  if (is_given || promise.method == risk_control_name(RiskControl::kEmpirical)) {
    return concat(nothing, "the threshold ", is_given ? "was given; " : "fits what was seen; ",
                  observed_misses(promise));
  }
  const double least_m = least_error_m(calibration_drives);
  if (promise.block_count > 0 && least_m > promise.limit_m) {
    return nothing + "no range reached " + format_double(promise.limit_m) +
           " m anywhere, the least error measured is " + format_double(least_m) + " m";
  }
  return nothing +
         (promise.scope == PromiseScope::kThisDrive ? why_this_drive(promise, card) + ", and "
                                                    : "") +
         what_is_wanting(promise, card, needed_blocks) +
         "; the threshold fits what was seen instead: " + observed_misses(promise);
}

}  // namespace sightline
