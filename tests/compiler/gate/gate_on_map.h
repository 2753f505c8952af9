#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "compiler/gate/gate.h"

namespace sightline {

inline const std::string kToday = "2026-06-15";

inline GateReport judged(const CompiledMap& map, const CompiledMap* old_map = nullptr,
                         const GateSettings& settings = default_gate_settings(),
                         const Observation* observation = nullptr) {
  MapSummary summary;
  summary.format = "1.0";
  const GateMap now{"maps/new town.slmap", map, summary};
  const GateMap before{"maps/old.slmap", old_map != nullptr ? *old_map : map, summary};
  const Result<GateReport> report =
      judge({now, old_map != nullptr ? &before : nullptr, observation}, settings, kToday);
  EXPECT_TRUE(report) << to_string(report.error());
  return *report;
}

inline std::vector<Check> checks_of(const GateReport& report, const std::string& rule,
                                    double limit_m = 0.0) {
  std::vector<Check> found;
  for (const Check& check : report.checks) {
    if (check.rule == rule && (limit_m == 0.0 || check.limit_m == limit_m)) found.push_back(check);
  }
  return found;
}

inline std::vector<Check> violations(const GateReport& report) {
  std::vector<Check> found;
  for (const Check& check : report.checks) {
    if (check.verdict == Verdict::kViolated) found.push_back(check);
  }
  return found;
}

}  // namespace sightline
