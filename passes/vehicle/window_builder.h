#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "formats/map/tiles/map_tiles.h"
#include "passes/matching/covariance/structure.h"
#include "passes/matching/localizer.h"

namespace sightline {

// A circle in the plane of the map.
struct MapCircle {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
};

// The NDs of all cells whose centres are in a circle, ready to be matched in.
struct MapWindow {
  MapCircle circle;
  Localizer own;
  Localizer samples;
  StructureMap structures;
};

struct WindowOptions {
  LocalizerOptions own;
  double usual_range_m = 50.0;  // of the map's longest look
  double mounting_m = 0.0;      // from the vehicle's frame to the sensor
};

// How far from where a match starts, in the plane, there are cells that it may read: farther
// ones do not change a bit of its result.
double match_reach_m(const WindowOptions& options, double range_m, double cell_m);

// Whether a window has all cells of the circle.
bool serves(const MapWindow& window, const MapCircle& circle);

// A tile that could not be read: windows are without its NDs.
struct TileFault {
  std::size_t tile = 0;
  Error error;
};

// Makes a window in steps of about a millisecond; reading one tile is a step.
class WindowBuilder {
 public:
  // `map` must outlive it.
  WindowBuilder(const MapTiles& map, const MapCircle& circle, const WindowOptions& options);
  // Of all NDs of a map.
  WindowBuilder(NdtMap whole, const WindowOptions& options);

  bool step();  // true once the window is ready
  [[nodiscard]] const MapWindow& window() const { return *window_; }
  std::shared_ptr<const MapWindow> take() { return std::move(window_); }
  [[nodiscard]] const std::vector<TileFault>& faults() const { return faults_; }

 private:
  void read_tile();

  const MapTiles* map_ = nullptr;
  LocalizerOptions options_;
  NdtMap ndt_;
  std::shared_ptr<MapWindow> window_;
  std::vector<std::size_t> tiles_;  // that meet the circle: their numbers in the map, ascending
  std::size_t read_count_ = 0;      // of these
  std::optional<LocalizerBuilder> own_;
  std::optional<LocalizerBuilder> samples_;
  std::vector<TileFault> faults_;
};

}  // namespace sightline
