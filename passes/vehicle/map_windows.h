#pragma once

#include <Eigen/Core>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "formats/base/result.h"
#include "formats/map/tiles/map_tiles.h"
#include "passes/vehicle/window_builder.h"

namespace sightline {

// The parts of a map that a vehicle matches in: at most two windows, of which one is being prepared
// while the other serves. What a match finds does not depend on which window it gets. Safe from
// several threads; vehicles in more than two places prepare windows again and again.
class MapWindows {
 public:
  MapWindows(const MapTiles& tiles, const WindowOptions& options);
  // One window with the whole map, which serves everywhere.
  MapWindows(NdtMap whole, const WindowOptions& options);
  MapWindows(const MapWindows&) = delete;
  MapWindows& operator=(const MapWindows&) = delete;
  ~MapWindows();

  // Prepares ahead of the latest match from here on. Without a thread a match does it at its place,
  // and prepare() ahead of it.
  void start_thread();

  // Of a match of points that far from a sensor, which starts at that place. Prepares it where no
  // window serves.
  std::shared_ptr<const MapWindow> at(const Eigen::Vector3d& p_map_m, double range_m);

  // Prepares what a vehicle at that place needs next. Takes steps, most of about a millisecond, at
  // least one, until the time is over. True once all is prepared.
  bool prepare(const Eigen::Vector3d& p_map_m, double budget_ms);

  // Tiles that could not be read, in the order in which they were needed.
  [[nodiscard]] std::size_t fault_count() const;
  [[nodiscard]] Error fault(std::size_t number) const;  // below fault_count()

 private:
  struct Need {
    Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
    Eigen::Vector2d heading = Eigen::Vector2d::Zero();  // of length 1; 0 while it is not known
    double reach_m = 0.0;
    bool is_known = false;
  };
  void note(const Eigen::Vector2d& place_m, double reach_m);
  std::shared_ptr<const MapWindow> held(const MapCircle& needed);
  [[nodiscard]] bool needs_more() const;
  static MapCircle wide(const Need& need);
  void begin(const MapCircle& circle);
  bool step_ahead();
  std::shared_ptr<const MapWindow> make(const MapCircle& needed);
  void give_up();
  bool step_builder();
  void run_thread();

  const MapTiles* tiles_ = nullptr;  // none of a whole map
  WindowOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::shared_ptr<const MapWindow>> windows_;  // the latest used first
  Need need_;
  std::vector<TileFault> faults_;
  bool is_stopped_ = false;
  std::mutex build_mutex_;  // taken before mutex_
  std::unique_ptr<WindowBuilder> builder_;
  std::atomic<int> waiting_count_ = 0;  // matches that need the builder
  std::thread thread_;
};

}  // namespace sightline
