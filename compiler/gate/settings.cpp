#include "compiler/gate/settings.h"

#include <chrono>
#include <cstdio>

namespace sightline {

bool is_date(std::string_view text) {
  int year = 0;
  unsigned month = 0;
  unsigned day = 0;
  int used = 0;
  const std::string copy(text);
  if (copy.size() != 10 ||
      std::sscanf(copy.c_str(), "%4d-%2u-%2u%n", &year, &month, &day, &used) != 3 || used != 10) {
    return false;
  }
  return std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(month),
                                     std::chrono::day(day))
      .ok();
}

int days_between(std::string_view from, std::string_view to) {
  const auto day_of = [](std::string_view text) {
    const std::string copy(text);
    const int year = std::stoi(copy.substr(0, 4));
    const auto month = static_cast<unsigned>(std::stoi(copy.substr(5, 2)));
    const auto day = static_cast<unsigned>(std::stoi(copy.substr(8, 2)));
    return std::chrono::sys_days(std::chrono::year_month_day(
        std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)));
  };
  return static_cast<int>((day_of(to) - day_of(from)).count());
}

GateSettings default_gate_settings() {
  GateSettings settings;
  for (const GateRule& rule : gate_rules()) {
    settings.rules[std::string(rule.id)] = {true, rule.severity, {rule.allowed, {}}};
  }
  return settings;
}

}  // namespace sightline
