#include "formats/evaluation/evaluation_scores.h"

namespace sightline {

std::string_view rule_name(Rule rule) {
  constexpr std::string_view kNames[kRuleCount] = {
      "map", "mean", "probability", "static-equal-coverage", "static-longest", "oracle"};
  return kNames[static_cast<std::size_t>(rule)];
}

}  // namespace sightline
