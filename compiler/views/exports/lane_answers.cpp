#include "compiler/views/exports/lane_answers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace sightline {
namespace {

constexpr double kStep_m = 1.0;

bool is_known(std::uint32_t flags) { return (flags & (kAnswerFar | kAnswerUnknownLocalizer)) == 0; }

std::size_t rank_of(const MapLook& look, std::span<const MapLook> cheapest_first) {
  const auto found = std::ranges::find(cheapest_first, look_of(look), look_of);
  return static_cast<std::size_t>(found - cheapest_first.begin());
}

// The dearer of two: the one that comes later in the map's order, or of two ranges the longer one.
bool is_dearer(const MapLook& a, const MapLook& b, std::span<const MapLook> cheapest_first) {
  const std::size_t rank_a = rank_of(a, cheapest_first);
  const std::size_t rank_b = rank_of(b, cheapest_first);
  return rank_a != rank_b ? rank_a > rank_b : a.range_m > b.range_m;
}

// Joins places that follow each other.
class StretchMaker {
 public:
  explicit StretchMaker(std::size_t steps) : steps_(static_cast<double>(steps)) {}

  // A place stands for half a step before and behind it.
  void add(std::size_t place, bool belongs) {
    const auto at = static_cast<double>(place);
    const double to = std::min(1.0, (at + 0.5) / steps_);
    if (belongs && did_belong_) stretches_.back().to = to;
    if (belongs && !did_belong_) stretches_.push_back({std::max(0.0, (at - 0.5) / steps_), to});
    did_belong_ = belongs;
  }
  std::vector<LaneStretch> take() { return std::move(stretches_); }

 private:
  double steps_;
  bool did_belong_ = false;
  std::vector<LaneStretch> stretches_;
};

}  // namespace

double nearest_rank(const std::vector<double>& ascending, double share) {
  const auto rank =
      static_cast<std::size_t>(std::ceil(share * static_cast<double>(ascending.size())));
  return ascending[std::clamp<std::size_t>(rank, 1, ascending.size()) - 1];
}

Look look_of(const MapLook& look) {
  return {.range_m = look.range_m,
          .return_count = look.return_count,
          .even_beyond_m = look.even_beyond_m,
          .point_count = look.point_count,
          .is_by_normals = look.is_by_normals,
          .mode = look.settles ? LookMode::kSettle : LookMode::kSearch};
}

Result<LaneAsker> LaneAsker::of(const MapReader& map, double sensor_height_m, WeakPlaces weak) {
  SIGHTLINE_ASSIGN(const std::vector<MapSite> sites, map.sites(0));
  LaneAsker asker;
  asker.map_ = &map;
  asker.sensor_height_m_ = sensor_height_m;
  asker.weak_ = std::move(weak);
  std::vector<Eigen::Vector3d> flat_m;
  for (const MapSite& site : sites) {
    const Eigen::Vector3d& site_m = asker.sites_m_.emplace_back(site.position_world_m.data());
    flat_m.emplace_back(site_m.x(), site_m.y(), 0.0);
  }
  asker.in_plane_ = PointGrid(flat_m);
  return asker;
}

std::array<double, 3> LaneAsker::sensor_world_m(const Eigen::Vector3d& road_world_m) const {
  const Eigen::Vector3d& p_m = road_world_m;
  if (!std::isnan(p_m.z())) return {p_m.x(), p_m.y(), p_m.z() + sensor_height_m_};
  const std::optional<NearPoint> site =
      in_plane_.nearest({p_m.x(), p_m.y(), 0.0}, map_->info().reach_m);
  return {p_m.x(), p_m.y(), site ? sites_m_[site->index].z() : 0.0};
}

std::vector<std::array<double, 3>> LaneAsker::levels_world_m(double x_m, double y_m) const {
  constexpr double kBeside_m = 2.0;
  std::vector<std::array<double, 3>> levels_m;
  const std::vector<NearPoint> near = in_plane_.within({x_m, y_m, 0.0}, map_->info().reach_m);
  for (const NearPoint& site : near) {
    if (site.distance_m > near.front().distance_m + kBeside_m) break;
    const double z_m = sites_m_[site.index].z();
    const bool is_known = std::ranges::any_of(
        levels_m, [&](const std::array<double, 3>& p_m) { return is_same_level(p_m[2], z_m); });
    if (!is_known) levels_m.push_back({x_m, y_m, z_m});
  }
  return levels_m;
}

double LaneAsker::distance_m(const Eigen::Vector3d& p_world_m) const {
  constexpr double kAnywhere_m = std::numeric_limits<double>::infinity();
  const std::optional<NearPoint> site =
      in_plane_.nearest({p_world_m.x(), p_world_m.y(), 0.0}, kAnywhere_m);
  return site ? site->distance_m : kAnywhere_m;
}

Result<LaneLimit> LaneAsker::ask(const std::vector<Eigen::Vector3d>& road_m,
                                 std::size_t limit) const {
  const MapInfo& info = map_->info();
  LaneLimit along;
  std::optional<MapLook> dearest;
  std::size_t range_unmet = 0;
  std::size_t look_unmet = 0;
  StretchMaker unmet(road_m.size() - 1);
  StretchMaker weak(road_m.size() - 1);
  for (std::size_t i = 0; i < road_m.size(); ++i) {
    const std::array<double, 3> p_m = sensor_world_m(road_m[i]);
    const double limit_m = info.limits_m[limit];
    SIGHTLINE_ASSIGN(const RangeAnswer range, map_->observation_range(p_m, limit_m));
    SIGHTLINE_ASSIGN(const LookAnswer look, map_->look(p_m, limit_m));
    const bool is_answered = is_known(range.flags);
    const bool is_range_unmet = is_answered && (range.flags & kAnswerUnmet) != 0;
    const bool is_look_unmet = is_answered && (look.flags & kAnswerUnmet) != 0;
    const bool is_unmet = is_range_unmet && is_look_unmet;
    if (is_answered) {
      along.ranges_m.push_back(range.range_m);
      range_unmet += is_range_unmet ? 1 : 0;
      look_unmet += is_look_unmet ? 1 : 0;
      if (!dearest || is_dearer(look.look, *dearest, info.looks)) dearest = look.look;
    }
    unmet.add(i, is_unmet);
    weak.add(i, is_answered && !is_unmet && weak_.is_weak(Eigen::Vector3d(p_m.data())));
  }
  along.unmet = unmet.take();
  along.weak = weak.take();
  if (!dearest) return along;
  std::ranges::sort(along.ranges_m);
  const auto count = static_cast<double>(along.ranges_m.size());
  along.unmet_share = static_cast<double>(range_unmet) / count;
  along.look_unmet_share = static_cast<double>(look_unmet) / count;
  along.look = look_of(*dearest);
  return along;
}

Result<LaneAnswers> LaneAsker::ask(const Lanelet& lanelet) const {
  const auto steps = static_cast<std::size_t>(std::ceil(lanelet.length_m / kStep_m));
  const std::vector<Eigen::Vector3d> road_m =
      middle_of(LineByShare(lanelet.left.points_m), LineByShare(lanelet.right.points_m),
                std::max<std::size_t>(1, steps));
  LaneAnswers answers;
  for (std::size_t limit = 0; limit < map_->info().limits_m.size(); ++limit) {
    SIGHTLINE_ASSIGN(LaneLimit along, ask(road_m, limit));
    answers.limits.push_back(std::move(along));
  }
  if (answers.limits.empty()) return answers;
  answers.known_share = static_cast<double>(answers.limits.front().ranges_m.size()) /
                        static_cast<double>(road_m.size());
  return answers;
}

Result<WeakPlaces> WeakPlaces::of(const CompiledMap& map, const WeakStretchOptions& options) {
  SIGHTLINE_ASSIGN(const std::size_t limit, limit_of(map, options.limit_m));
  WeakPlaces places;
  places.origin_world_m_ = map.sites.frame.origin_world_m;
  places.sites_ = PointGrid(positions_m(map.sites));
  places.is_weak_.resize(map.sites.sites.size());
  const std::vector<BestLook> best = best_looks(map, limit);
  for (const WeakStretch& stretch : weak_stretches(map.sites, best, options)) {
    for (std::size_t site = stretch.first_site; site <= stretch.last_site; ++site) {
      places.is_weak_[site] = true;
    }
  }
  return places;
}

bool WeakPlaces::is_weak(const Eigen::Vector3d& sensor_world_m) const {
  const std::optional<NearPoint> site = sites_.nearest_on_level(
      sensor_world_m - origin_world_m_, std::numeric_limits<double>::infinity());
  return site && is_weak_[site->index];
}

}  // namespace sightline
