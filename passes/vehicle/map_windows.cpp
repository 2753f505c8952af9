#include "passes/vehicle/map_windows.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <system_error>
#include <utility>

// A window that serves is exchanged for the next one before the vehicle leaves it, so that no match
// waits. A match that finds none prepares it itself, by the same steps: what was begun is taken
// over where it will serve.

namespace sightline {
namespace {

// Preparing begins where the windows end so far ahead: 0.4 s at 30 m/s.
constexpr double kAhead_m = 12.0;
constexpr double kHeadingStep_m = 1.0;   // steps that are shorter have no heading
constexpr double kLongestStep_m = 64.0;  // of one vehicle between two matches
constexpr std::size_t kMostWindows = 2;

double now_ms() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

}  // namespace

// From the place to where the vehicle is next.
MapCircle MapWindows::wide(const Need& need) {
  return {need.place_m + kAhead_m * need.heading, need.reach_m + 2.0 * kAhead_m};
}

MapWindows::MapWindows(const MapTiles& tiles, const WindowOptions& options)
    : tiles_(&tiles), options_(options) {
  need_.reach_m = match_reach_m(options, options.usual_range_m, tiles.head().ndt.cell_m);
}

MapWindows::MapWindows(NdtMap whole, const WindowOptions& options) : options_(options) {
  WindowBuilder builder(std::move(whole), options);
  while (!builder.step()) {
  }
  windows_.push_back(builder.take());
}

MapWindows::~MapWindows() {
  {
    const std::scoped_lock lock(mutex_);
    is_stopped_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void MapWindows::start_thread() {
  if (tiles_ == nullptr) return;
  try {
    thread_ = std::thread([this] { run_thread(); });
  } catch (const std::system_error&) {
    // Without a thread each match prepares what it needs.
  }
}

// mutex_ is held.
void MapWindows::note(const Eigen::Vector2d& place_m, double reach_m) {
  const Eigen::Vector2d step_m = place_m - need_.place_m;
  const double length_m = step_m.norm();
  if (!need_.is_known || length_m >= kHeadingStep_m) {
    const bool is_drive = need_.is_known && length_m <= kLongestStep_m;
    need_.heading = Eigen::Vector2d::Zero();
    if (is_drive) need_.heading = step_m / length_m;
    need_.place_m = place_m;
    need_.is_known = true;
  }
  need_.reach_m = std::max(need_.reach_m, reach_m);
}

// mutex_ is held. Null where none serves.
std::shared_ptr<const MapWindow> MapWindows::held(const MapCircle& needed) {
  for (auto window = windows_.begin(); window != windows_.end(); ++window) {
    if (!serves(**window, needed)) continue;
    std::rotate(windows_.begin(), window, window + 1);
    return windows_.front();
  }
  return nullptr;
}

// mutex_ is held.
bool MapWindows::needs_more() const {
  if (!need_.is_known) return false;
  return std::ranges::none_of(windows_, [&](const std::shared_ptr<const MapWindow>& window) {
    return serves(*window, {need_.place_m, need_.reach_m + kAhead_m});
  });
}

// build_mutex_ is held. Frees the older window first, so that there are never three.
void MapWindows::begin(const MapCircle& circle) {
  std::vector<std::shared_ptr<const MapWindow>> freed;
  {
    const std::scoped_lock lock(mutex_);
    while (windows_.size() >= kMostWindows) {
      freed.push_back(std::move(windows_.back()));
      windows_.pop_back();
    }
  }
  builder_ = std::make_unique<WindowBuilder>(*tiles_, circle, options_);
}

// build_mutex_ is held. True once the window is there.
bool MapWindows::step_builder() {
  if (!builder_->step()) return false;
  const std::scoped_lock lock(mutex_);
  for (const TileFault& fault : builder_->faults()) {
    if (std::ranges::find(faults_, fault.tile, &TileFault::tile) == faults_.end()) {
      faults_.push_back(fault);
    }
  }
  windows_.insert(windows_.begin(), builder_->take());
  builder_.reset();
  return true;
}

// build_mutex_ is held. False where nothing is left to prepare.
bool MapWindows::step_ahead() {
  Need need;
  {
    const std::scoped_lock lock(mutex_);
    need = need_;
    if (!needs_more()) need.is_known = false;
  }
  if (!need.is_known) {
    builder_.reset();
    return false;
  }
  const MapCircle ahead{need.place_m, need.reach_m + kAhead_m};
  if (builder_ == nullptr || !serves(builder_->window(), ahead)) begin(wide(need));
  step_builder();
  return true;
}

// build_mutex_ is held. The first match is not to wait for a window of the map's longest look.
std::shared_ptr<const MapWindow> MapWindows::make(const MapCircle& needed) {
  while (true) {
    Need need;
    bool is_first = false;
    {
      const std::scoped_lock lock(mutex_);
      std::shared_ptr<const MapWindow> window = held(needed);
      if (window != nullptr) return window;
      need = need_;
      is_first = windows_.empty();
    }
    need.place_m = needed.centre_m;
    if (builder_ == nullptr || !serves(builder_->window(), needed)) {
      if (is_first) need.reach_m = needed.radius_m;
      begin(wide(need));
    }
    while (!step_builder()) {
    }
  }
}

std::shared_ptr<const MapWindow> MapWindows::at(const Eigen::Vector3d& p_map_m, double range_m) {
  if (tiles_ == nullptr) return windows_.front();
  const double reach_m = match_reach_m(options_, range_m, tiles_->head().ndt.cell_m);
  const MapCircle needed{p_map_m.head<2>(), reach_m};
  {
    const std::scoped_lock lock(mutex_);
    note(needed.centre_m, reach_m);
    std::shared_ptr<const MapWindow> window = held(needed);
    if (thread_.joinable() && (window == nullptr || needs_more())) wake_.notify_one();
    if (window != nullptr) return window;
  }
  ++waiting_count_;
  const std::scoped_lock building(build_mutex_);
  --waiting_count_;
  return make(needed);
}

bool MapWindows::prepare(const Eigen::Vector3d& p_map_m, double budget_ms) {
  if (tiles_ == nullptr) return true;
  const double end_ms = now_ms() + budget_ms;
  {
    const std::scoped_lock lock(mutex_);
    note(p_map_m.head<2>(), 0.0);
  }
  do {
    const std::scoped_lock building(build_mutex_);
    if (!step_ahead()) return true;
  } while (now_ms() < end_ms);
  return false;
}

std::size_t MapWindows::fault_count() const {
  const std::scoped_lock lock(mutex_);
  return faults_.size();
}

Error MapWindows::fault(std::size_t number) const {
  const std::scoped_lock lock(mutex_);
  return faults_[number].error;
}

// Until the next match.
void MapWindows::give_up() {
  const std::scoped_lock building(build_mutex_);
  builder_.reset();
  const std::scoped_lock lock(mutex_);
  need_.is_known = false;
}

void MapWindows::run_thread() {
  std::unique_lock lock(mutex_);
  while (!is_stopped_) {
    if (!needs_more()) {
      wake_.wait(lock);
      continue;
    }
    lock.unlock();
    while (waiting_count_ > 0) std::this_thread::yield();
    try {
      const std::scoped_lock building(build_mutex_);
      step_ahead();
    } catch (const std::bad_alloc&) {
      give_up();  // the match that needs it reports it
    }
    lock.lock();
  }
}

}  // namespace sightline
