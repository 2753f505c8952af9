#pragma once

#include <optional>
#include <vector>

#include "compiler/gate/rules/finding.h"
#include "compiler/gate/rules/rules.h"

// Stretches of route: where along it a number is bad.

namespace sightline {

RouteStretch stretch_between(const Sites& sites, std::size_t first, std::size_t last);

// "sites 120 to 163 (run 0, 120 to 163 m, around (12.0, -64.5, 1.8) m in the world)"
std::string in_words(const RouteStretch& stretch);

struct StretchSearch {
  double length_m = 0.0;  // of route that is judged at a time
  Bound bound = Bound::kAtMost;
};

struct BadStretch {
  std::size_t first = 0;  // sites
  std::size_t last = 0;
  double worst = 0.0;  // mean over the worst `length_m` in it
  std::size_t worst_first = 0;
  std::size_t worst_last = 0;
};

// Means of `value` over every piece of route of length_m (a run that is shorter: all of it). Those
// that are not within `allowed` are joined where they touch, and cut at both ends back to the first
// and last site that is itself not within it. NaN: the site has no value and ends a piece. The
// stretches ascend by site.
std::vector<BadStretch> bad_stretches(const Sites& sites, const std::vector<double>& value,
                                      const StretchSearch& search, double allowed);

// The worst such piece, the first on a tie; `last` < `first` where no site has a value.
BadStretch worst_stretch(const Sites& sites, const std::vector<double>& value,
                         const StretchSearch& search);

// Those bad stretches, or the worst where none is bad (`allowed`: none: nothing is bad).
std::vector<BadStretch> bad_or_worst(const Sites& sites, const std::vector<double>& value,
                                     const StretchSearch& search, std::optional<double> allowed);

// Longest piece of route whose sites are all `is_bad`, with its length between first and last site;
// each piece longer than `longer_than_m`, ascending by site.
struct LongStretch {
  std::size_t first = 0;
  std::size_t last = 0;
  double length_m = 0.0;
};
std::vector<LongStretch> long_stretches(const Sites& sites, const std::vector<bool>& is_bad);

}  // namespace sightline
