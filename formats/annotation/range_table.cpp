#include "formats/annotation/range_table.h"

#include <cmath>
#include <string>

#include "formats/annotation/of_samples.h"

namespace sightline {
namespace {

bool is_share(double value) { return value >= 0.0 && value <= 1.0; }

Result<void> validate_promise(const RangeTable& table, std::size_t limit) {
  const LimitPromise& promise = table.promises[limit];
  const double above_m = limit == 0 ? 0.0 : table.promises[limit - 1].limit_m;
  const std::string place = "limit " + std::to_string(limit);
  if (!std::isfinite(promise.limit_m) || promise.limit_m <= above_m) {
    return invalid_artifact("found a limit of " + format_double(promise.limit_m) +
                                " m, expected ascending ones above 0",
                            place);
  }
  if (!is_share(promise.probability_threshold) || !is_share(promise.history_threshold) ||
      !is_share(promise.alpha) || !is_share(promise.delta) ||
      !is_share(promise.calibration_miss_share)) {
    return invalid_artifact("a threshold, alpha, delta or share of misses lies outside 0 to 1",
                            place);
  }
  if (promise.scope > PromiseScope::kNextDrive ||
      (promise.is_earned && promise.scope != PromiseScope::kNextDrive)) {
    return invalid_artifact("a promise is about the next drive, and this one is not", place);
  }
  return {};
}

Result<void> validate_shape(const RangeTable& table) {
  const std::size_t pairs = table.shape().size(table.site_count);
  SIGHTLINE_TRY(validate(table.looks));
  if (table.looks.size() > 256 || table.promises.empty()) {
    return invalid_artifact("found " + std::to_string(table.looks.size()) + " looks and " +
                                std::to_string(table.promises.size()) +
                                " limits, expected 1 to 256 and at least 1",
                            "");
  }
  if (table.range_index.size() != pairs || table.flags.size() != pairs) {
    return invalid_artifact("choices do not fill " + std::to_string(table.site_count) +
                                " sites x " + std::to_string(table.promises.size()) + " limits",
                            "");
  }
  if (table.selection != Selection::kMean && table.selection != Selection::kProbability) {
    return invalid_artifact("found an unknown selection", "");
  }
  if (!std::isfinite(table.dilation_m) || table.dilation_m < 0.0) {
    return invalid_artifact("found a dilation of " + format_double(table.dilation_m) + " m", "");
  }
  return {};
}

Result<void> validate_choice(const RangeTable& table, std::size_t site, std::size_t limit) {
  const std::size_t i = table.shape().index(site, limit);
  const std::string place = "site " + std::to_string(site);
  if (table.range_index[i] >= table.looks.size()) {
    return invalid_artifact("found range " + std::to_string(table.range_index[i]) + " of " +
                                std::to_string(table.looks.size()),
                            place);
  }
  if ((table.flags[i] & ~(kUnmet | kExtrapolated | kStatic | kSimulatedAnswer)) != 0) {
    return invalid_artifact("found an unknown flag", place);
  }
  if (limit > 0 && table.range_index[i] > table.range_index[i - 1]) {
    return invalid_artifact("a looser limit looks further than a tighter one", place);
  }
  return {};
}

void append_rows(const RangeTable& table, Table& out) {
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
      const std::uint8_t flags = table.flags_of(site, limit);
      out.rows.push_back({static_cast<std::int64_t>(site), table.promises[limit].limit_m,
                          table.range_m(site, limit),
                          to_text(table.looks[table.range(site, limit)]),
                          std::int64_t{(flags & kUnmet) != 0 ? 1 : 0},
                          std::int64_t{(flags & kExtrapolated) != 0 ? 1 : 0},
                          std::int64_t{(flags & kStatic) != 0 ? 1 : 0}});
    }
  }
}

// `prefix`: "", or "look_" for those that take a sample.
void append_promises(const RangeTable& table, const std::string& prefix, Table& out) {
  for (const LimitPromise& promise : table.promises) {
    const std::string limit = prefix + "limit_" + format_double(promise.limit_m) + "_m_";
    out.facts.emplace_back(limit + "method", promise.method);
    out.facts.emplace_back(limit + "probability_threshold", promise.probability_threshold);
    out.facts.emplace_back(limit + "history_threshold", promise.history_threshold);
    out.facts.emplace_back(limit + "alpha", promise.alpha);
    out.facts.emplace_back(limit + "delta", promise.delta);
    out.facts.emplace_back(limit + "block_count", std::int64_t{promise.block_count});
    out.facts.emplace_back(limit + "place_count", std::int64_t{promise.place_count});
    out.facts.emplace_back(limit + "drive_count", std::int64_t{promise.drive_count});
    out.facts.emplace_back(limit + "scope", std::string(promise_scope_name(promise.scope)));
    out.facts.emplace_back(limit + "is_earned", std::int64_t{promise.is_earned ? 1 : 0});
    out.facts.emplace_back(limit + "calibration_miss_share", promise.calibration_miss_share);
    out.facts.emplace_back(limit + "statement", promise.statement);
  }
}

Result<void> validate_plan(const RangeTable& table) {
  if (!table.plan) return {};
  if (takes_every_return(table.looks.front())) {
    return invalid_artifact("found a plan of looks in a table of ranges", "");
  }
  const Result<void> valid = validate(*table.plan);
  return valid ? valid : invalid_artifact(valid.error().message, valid.error().place);
}

Result<void> validate_own(const RangeTable& table) {
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

const std::vector<Look>& looks_of(const RangeTable& table) { return table.looks; }

void encode_own(const RangeTable& table, ByteWriter& writer) {
  encode(table.looks, writer);
  writer.put(table.selection);
  writer.put(table.dilation_m);
  writer.put<std::uint8_t>(table.extrapolated_takes_static ? 1 : 0);
  writer.put<std::uint64_t>(table.promises.size());
  for (const LimitPromise& promise : table.promises) {
    writer.put(promise.limit_m);
    writer.put(promise.probability_threshold);
    writer.put(promise.history_threshold);
    writer.put(promise.alpha);
    writer.put(promise.delta);
    writer.put(promise.block_count);
    writer.put(promise.place_count);
    writer.put(promise.drive_count);
    writer.put(promise.scope);
    writer.put<std::uint8_t>(promise.is_earned ? 1 : 0);
    writer.put(promise.calibration_miss_share);
    writer.put_string(promise.method);
    writer.put_string(promise.statement);
  }
  writer.put(table.site_count);
  writer.put_array(table.range_index);
  writer.put_array(table.flags);
  writer.put<std::uint8_t>(table.plan ? 1 : 0);
  if (table.plan) encode(*table.plan, writer);
}

void decode_own(ByteReader& reader, RangeTable& table) {
  constexpr std::size_t kBytesPerPromise =
      6 * sizeof(double) + 3 * 4 + 2 + 2 * sizeof(std::uint64_t);
  decode(reader, table.looks);
  reader.get(table.selection);
  reader.get(table.dilation_m);
  table.extrapolated_takes_static = reader.get<std::uint8_t>() != 0;
  table.promises.resize(reader.get_count(kBytesPerPromise));
  for (LimitPromise& promise : table.promises) {
    reader.get(promise.limit_m);
    reader.get(promise.probability_threshold);
    reader.get(promise.history_threshold);
    reader.get(promise.alpha);
    reader.get(promise.delta);
    reader.get(promise.block_count);
    reader.get(promise.place_count);
    reader.get(promise.drive_count);
    reader.get(promise.scope);
    const auto is_earned = reader.get<std::uint8_t>();
    if (is_earned > 1) reader.fail();
    promise.is_earned = is_earned == 1;
    reader.get(promise.calibration_miss_share);
    reader.get_string(promise.method);
    reader.get_string(promise.statement);
  }
  reader.get(table.site_count);
  reader.get_array(table.range_index);
  reader.get_array(table.flags);
  const auto has_plan = reader.get<std::uint8_t>();
  if (has_plan > 1) reader.fail();
  if (has_plan == 1) decode(reader, table.plan.emplace());
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

std::string_view selection_name(Selection selection) {
  return selection == Selection::kMean ? "mean" : "probability";
}

std::string_view promise_scope_name(PromiseScope scope) {
  return scope == PromiseScope::kNextDrive ? "next-drive" : "this-drive";
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
  return validate_both(table, validate_own, looks_of);
}

Table dump(const RangeTable& table) {
  Table out;
  out.name = "ranges";
  out.facts.emplace_back("selection", std::string(selection_name(table.selection)));
  out.facts.emplace_back("dilation_m", table.dilation_m);
  append_promises(table, "", out);
  for (const RangeTable& samples : table.of_samples) append_promises(samples, "look_", out);
  out.columns = {"site", "limit_m", "range_m", "look", "unmet", "extrapolated", "static"};
  append_rows(table, out);
  for (const RangeTable& samples : table.of_samples) append_rows(samples, out);
  return out;
}

void encode(const RangeTable& table, ByteWriter& writer) { encode_both(table, writer, encode_own); }

void decode(ByteReader& reader, RangeTable& table) { decode_both(reader, table, decode_own); }

}  // namespace sightline
