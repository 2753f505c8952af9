#pragma once

#include <string>
#include <vector>

#include "compiler/gate/settings.h"
#include "passes/pass/options.h"

// The numbers and words of the gate's settings as option fields: its reader and its published
// schema work from them.

namespace sightline {

struct GateOptions {
  double stretch_m = 0.0;
  double change_stretch_m = 0.0;
  std::string fails_at;
};
std::vector<OptionField> option_fields(GateOptions& options);
GateOptions options_of(const GateSettings& settings);

struct RuleOptions {
  std::string severity;
  double allowed = 0.0;
};
std::vector<OptionField> option_fields(RuleOptions& options);

struct ExceptionOptions {
  std::string rule;
  double limit_m = 0.0;
  std::string reason;
  std::string until;
};
std::vector<OptionField> option_fields(ExceptionOptions& options);

struct RouteOptions {
  int run = 0;
  double from_s_m = 0.0;
  double to_s_m = 0.0;
};
std::vector<OptionField> option_fields(RouteOptions& options);

}  // namespace sightline
