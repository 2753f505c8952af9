#pragma once

#include <Eigen/Core>
#include <vector>

#include "formats/drive/look.h"
#include "formats/foreign/lanes/lanelet_map.h"
#include "formats/grid/point_grid.h"
#include "formats/map/compiled_map.h"
#include "formats/reader/reader.h"
#include "passes/weakness/weak_stretches.h"

namespace sightline {

// Where a map is weak (weak_stretches.h), for places beside its sites.
class WeakPlaces {
 public:
  WeakPlaces() = default;
  // Of the limit that the options name. Error: bad-argument (no limit of the map).
  static Result<WeakPlaces> of(const CompiledMap& map, const WeakStretchOptions& options);

  // Whether the site nearest to a sensor there belongs to a weak stretch; world coordinates.
  [[nodiscard]] bool is_weak(const Eigen::Vector3d& sensor_world_m) const;

 private:
  Eigen::Vector3d origin_world_m_ = Eigen::Vector3d::Zero();
  PointGrid sites_;
  std::vector<bool> is_weak_;  // of each
};

// A part of a lanelet, as shares of its length from its begin.
struct LaneStretch {
  double from = 0.0;
  double to = 1.0;
};

// Along one lanelet, for one limit. Shares are of the places that have an answer.
struct LaneLimit {
  std::vector<double> ranges_m;  // of each of these places, ascending
  double unmet_share = 0.0;      // where no range is good enough
  Look look;                     // the dearest that one of them asks for
  double look_unmet_share = 0.0;
  std::vector<LaneStretch> unmet;  // where neither a range nor a look is; ascending
  std::vector<LaneStretch> weak;   // where one is, and the map is weak all the same; ascending
};

struct LaneAnswers {
  double known_share = 0.0;       // of all places of the lanelet, those with an answer
  std::vector<LaneLimit> limits;  // as MapInfo::limits_m
};

// The value that a share of ascending values does not exceed: the nearest rank.
double nearest_rank(const std::vector<double>& ascending, double share);

// The look of an answer, as the compiler knows it.
Look look_of(const MapLook& look);

// Asks a map for its sensor's places above a road.
class LaneAsker {
 public:
  // The map must be open for the localizer whose errors it holds, and outlives this. `weak`: where
  // the same map is weak, by any limit; none: nowhere. Errors: those of MapReader::sites().
  static Result<LaneAsker> of(const MapReader& map, double sensor_height_m, WeakPlaces weak = {});

  // The sensor's place above a point of a road, in world coordinates. Where the road's height is
  // not known (NaN) it is as high as at the nearest site in the plane.
  [[nodiscard]] std::array<double, 3> sensor_world_m(const Eigen::Vector3d& road_world_m) const;

  // The sensor's places over a point of the plane, one on each level: as high as the nearest site
  // in the plane, then as others at most 2 m farther away that are on no level of those before.
  [[nodiscard]] std::vector<std::array<double, 3>> levels_world_m(double x_m, double y_m) const;

  // In the plane, to the nearest site; infinity where a map has none.
  [[nodiscard]] double distance_m(const Eigen::Vector3d& p_world_m) const;

  // Asks at places a metre apart or a little less along the line halfway between both sides, both
  // ends among them. Errors: those of MapReader::look().
  [[nodiscard]] Result<LaneAnswers> ask(const Lanelet& lanelet) const;

 private:
  LaneAsker() = default;
  [[nodiscard]] Result<LaneLimit> ask(const std::vector<Eigen::Vector3d>& road_m,
                                      std::size_t limit) const;

  const MapReader* map_ = nullptr;
  double sensor_height_m_ = 0.0;
  WeakPlaces weak_;
  std::vector<Eigen::Vector3d> sites_m_;  // world coordinates
  PointGrid in_plane_;
};

}  // namespace sightline
