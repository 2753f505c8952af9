#pragma once

#include <map>
#include <optional>
#include <utility>

#include "compiler/views/verdict/answer_kind.h"
#include "formats/grid/point_grid.h"
#include "formats/map/compiled_map.h"

namespace sightline {

// Counts, for each kind of answer and limit, the errors within the limit at places where the map
// has an answer that it calls good enough. Scans farther than the map's reach from any site, and
// limits that the map does not have, are left out. The map must outlive it.
class AnsweredShares {
 public:
  explicit AnsweredShares(const CompiledMap& map);

  void add_site(AnswerKind kind, double limit_m, std::size_t site, double error_m);
  void add_scan(AnswerKind kind, double limit_m, const Eigen::Vector2d& p_map_m, double error_m);

  // Share of those added; 1 where there is none.
  [[nodiscard]] double share(AnswerKind kind, double limit_m) const;

 private:
  struct Count {
    std::size_t all = 0;
    std::size_t within = 0;
  };

  const CompiledMap& map_;
  PointGrid sites_;  // in the plane
  std::map<std::pair<AnswerKind, double>, Count> counts_;
};

// Of looks whose errors at single sites are not known: misses count against the places with an
// answer only as far as all places without one cannot explain them. `limit`: index among the map's;
// the map has looks.
double answered_coverage_of_looks(const CompiledMap& map, std::size_t limit, double coverage);

}  // namespace sightline
