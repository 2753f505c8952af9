#include "formats/annotation/range_table.h"

#include <cmath>
#include <string>

#include "formats/record/cells.h"

namespace sightline {
namespace {

bool is_share(double value) { return value >= 0.0 && value <= 1.0; }

Result<void> validate_promise(const RangeTable& table, std::size_t limit) {
  const LimitPromise& promise = table.promises[limit];
  const double above_m = limit == 0 ? 0.0 : table.promises[limit - 1].limit_m;
  const std::string place = concat("limit ", limit);
  if (!std::isfinite(promise.limit_m) || promise.limit_m <= above_m) {
    return invalid_artifact(concat("found a limit of ", format_double(promise.limit_m),
                                   " m, expected ascending ones above 0"),
                            place);
  }
  if (!is_share(promise.probability_threshold) || !is_share(promise.history_threshold) ||
      !is_share(promise.alpha) || !is_share(promise.delta) ||
      !is_share(promise.calibration_miss_share) || !is_share(promise.answered_share)) {
    return invalid_artifact("a threshold, alpha, delta or share of sites is outside 0 to 1", place);
  }
  if (promise.scope > PromiseScope::kNextDrive ||
      (promise.is_earned && promise.scope != PromiseScope::kNextDrive)) {
    return invalid_artifact("a promise must have the scope next-drive", place);
  }
  return {};
}

Result<void> validate_shape(const RangeTable& table) {
  const std::size_t pairs = table.shape().size(table.site_count);
  SIGHTLINE_TRY(validate(table.looks));
  if (table.looks.size() > 256 || table.promises.empty()) {
    return invalid_artifact(
        concat("found ", table.looks.size(), " looks and ", table.promises.size(),
               " limits, expected 1 to 256 and at least 1"),
        "");
  }
  if (table.range_index.size() != pairs || table.flags.size() != pairs ||
      table.reasons.size() != pairs) {
    return invalid_artifact(concat("choices do not fill ", table.site_count, " sites x ",
                                   table.promises.size(), " limits"),
                            "");
  }
  if (table.selection != Selection::kMean && table.selection != Selection::kProbability) {
    return invalid_artifact("found an unknown selection", "");
  }
  if (!std::isfinite(table.dilation_m) || table.dilation_m < 0.0) {
    return invalid_artifact(concat("found a dilation of ", format_double(table.dilation_m), " m"),
                            "");
  }
  return {};
}

Result<void> validate_choice(const RangeTable& table, std::size_t site, std::size_t limit) {
  const std::size_t i = table.shape().index(site, limit);
  const std::string place = concat("site ", site);
  if (table.range_index[i] >= table.looks.size()) {
    return invalid_artifact(
        concat("found range ", table.range_index[i], " of ", table.looks.size()), place);
  }
  if ((table.flags[i] & ~(kUnmet | kExtrapolated | kStatic | kSimulatedAnswer)) != 0) {
    return invalid_artifact("found an unknown flag", place);
  }
  if (table.reasons[i] == Reason::kNone || name_of(table.reasons[i]).empty()) {
    return invalid_artifact("the reason of a choice is missing or unknown", place);
  }
  if (limit > 0 && table.range_index[i] > table.range_index[i - 1]) {
    return invalid_artifact("a looser limit has a longer range than a tighter one", place);
  }
  return {};
}

Result<void> validate_plan(const RangeTable& table) {
  if (!table.plan) return {};
  if (takes_every_return(table.looks.front())) {
    return invalid_artifact("found a plan of looks in a table of ranges", "");
  }
  const Result<void> valid = validate(*table.plan);
  return valid ? valid : invalid_artifact(valid.error().message, valid.error().place);
}

}  // namespace

const std::vector<std::string>& risk_control_names() {
  static const std::vector<std::string> kNames = {"conformal", "learn-then-test", "empirical",
                                                  "fixed"};
  return kNames;
}

const std::string& risk_control_name(RiskControl control) {
  return risk_control_names().at(static_cast<std::size_t>(control));
}

std::uint32_t simulated_site_count(const RangeTable& table) {
  const SiteShape shape = table.shape();
  std::uint32_t count = 0;
  for (std::size_t site = 0; site < table.site_count; ++site) {
    bool is_simulated = false;
    for (std::size_t i = shape.size(site); i < shape.size(site + 1); ++i) {
      is_simulated |= (table.flags[i] & kSimulatedAnswer) != 0;
    }
    count += is_simulated ? 1 : 0;
  }
  return count;
}

Result<void> validate(const RangeTable& table) {
  SIGHTLINE_TRY(validate_shape(table));
  SIGHTLINE_TRY(validate_plan(table));
  for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
    SIGHTLINE_TRY(validate_promise(table, limit));
    for (std::size_t site = 0; site < table.site_count; ++site) {
      SIGHTLINE_TRY(validate_choice(table, site, limit));
    }
  }
  return {};
}

Table dump(const RangeTable& table) {
  Table out;
  out.name = "ranges";
  out.facts = {{"selection", cell_of(table.selection)}, {"dilation_m", table.dilation_m}};
  for (const LimitPromise& promise : table.promises) {
    const std::string limit = concat("limit_", format_double(promise.limit_m), "_m_");
    visit_cells(promise, [&](const std::string& name, const Cell& cell) {
      if (name != "limit_m") out.facts.emplace_back(limit + name, cell);
    });
  }
  out.columns = {"site", "limit_m", "range_m", "look", "unmet", "extrapolated", "static", "reason"};
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
      const std::uint8_t flags = table.flags_of(site, limit);
      out.rows.push_back(
          {static_cast<std::int64_t>(site), table.promises[limit].limit_m,
           table.range_m(site, limit), to_text(table.looks[table.range(site, limit)]),
           std::int64_t{(flags & kUnmet) != 0 ? 1 : 0},
           std::int64_t{(flags & kExtrapolated) != 0 ? 1 : 0},
           std::int64_t{(flags & kStatic) != 0 ? 1 : 0}, cell_of(table.reason(site, limit))});
    }
  }
  return out;
}

}  // namespace sightline
