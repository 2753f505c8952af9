#include "compiler/gate/rules/finding.h"

#include <algorithm>
#include <array>

namespace sightline {

std::string_view severity_name(Severity severity) {
  static constexpr std::array<std::string_view, 3> kNames = {"note", "warning", "error"};
  return kNames[static_cast<std::size_t>(severity)];
}

std::string_view verdict_name(Verdict verdict) {
  static constexpr std::array<std::string_view, 4> kNames = {"met", "violated", "excepted",
                                                             "not-judged"};
  return kNames[static_cast<std::size_t>(verdict)];
}

std::size_t GateReport::count(Verdict verdict) const {
  return static_cast<std::size_t>(std::ranges::count(checks, verdict, &Check::verdict));
}

std::size_t GateReport::violations(Severity severity) const {
  return static_cast<std::size_t>(std::ranges::count_if(checks, [&](const Check& check) {
    return check.verdict == Verdict::kViolated && check.severity == severity;
  }));
}

bool GateReport::passes() const {
  return std::ranges::none_of(checks, [&](const Check& check) {
    return check.verdict == Verdict::kViolated && check.severity >= fails_at;
  });
}

}  // namespace sightline
