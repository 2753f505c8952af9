#include "passes/matching/localizer.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "formats/base/check.h"
#include "formats/surroundings/cell_moments.h"

// Why levels: wide NDs have a wide basin and a blunt optimum, sharp ones the reverse. A first level
// may end far from its optimum and needs few points; the last takes three or four evaluations.

namespace sightline {
namespace {

constexpr std::size_t kMostLevels = 3;
// A start a metre off must feel the right wall. Narrow cells have narrow NDs: at 1 m, 0.1 m of blur
// loses starts that 0.2 m finds; at 2 m it finds as many and takes a tenth less time.
constexpr double kBlurTimesCell_m2 = 0.2;
constexpr double kSharpFloor = 0.003;  // of the largest eigenvalue: 3 cm in a wall of 2 m
constexpr std::size_t kThinStride = 4;

// An ND's eigenvalues below `floor` of the largest raised to it, then all by the blur's square.
InformationOfNd information(double floor, double blur_m) {
  return [floor, blur_m](const Nd& nd) -> Eigen::Matrix3d {
    const Eigen::Vector3d lambda_m2 =
        (nd.eigenvalues_m2.cwiseMax(floor * nd.eigenvalues_m2[0]).array() + blur_m * blur_m)
            .matrix();
    const Eigen::Matrix3d inverse =
        nd.eigenvectors * lambda_m2.cwiseInverse().asDiagonal() * nd.eigenvectors.transpose();
    return 0.5 * (inverse + inverse.transpose());
  };
}

// Of so many levels. All but the last show the way to the next: a part of the points, ended early.
MatchLevel annealed_level(std::size_t number, std::size_t count, const LocalizerOptions& options) {
  MatchLevel level;
  level.has_quick_steps = options.has_quick_steps;
  if (number + 1 == count) return level;
  level.is_thin = true;
  level.stop_step_m = (number == 0 ? 1.0 : 0.5) * options.lead_stop_m;
  return level;
}

// Those of the last level.
void limit_steps(const MatchOptions& options, MatchLevel& level) {
  level.max_step_m = options.max_step_m;
  level.max_step_rad = options.max_step_rad;
  level.stop_step_m = options.stop_step_m;
  level.stop_step_rad = options.stop_step_rad;
}

void check(const LocalizerOptions& options) {
  SIGHTLINE_CHECK(options.coarse_cells >= 1);
  SIGHTLINE_CHECK(options.search_m <= 0.0 || options.is_annealed);
}

std::size_t level_count(const LocalizerOptions& options) {
  return (options.is_annealed ? 2U : 1U) + (options.coarse_cells > 1 ? 1U : 0U);
}

// Whether that level's cells are the map's own; those of the others are the coarse map's.
bool is_of_map(std::size_t number, const LocalizerOptions& options) {
  return options.coarse_cells == 1 || number + 1 == level_count(options);
}

InformationOfNd information_of(std::size_t number, const LocalizerOptions& options,
                               double widest_cell_m) {
  if (!options.is_annealed) return plain_information_per_m2;
  return number == 0 ? information(0.01, kBlurTimesCell_m2 / widest_cell_m)
                     : information(kSharpFloor, 0.0);
}

MatchLevel settings_of(std::size_t number, const LocalizerOptions& options) {
  if (options.is_annealed) return annealed_level(number, level_count(options), options);
  return {.has_quick_steps = options.has_quick_steps};
}

constexpr std::string_view kNames[] = {"plain", "annealed", "searching", "pcl-ndt"};

// A turn is small enough when it moves the farthest point no farther than the step allowed in
// translation: seen 10 m far, a milliradian is a centimetre.
void stop_where_points_rest(const ScanForMatch& scan, std::span<MatchLevel> levels) {
  const double lever_m = std::clamp(scan.farthest_m, 1.0, 50.0);
  for (MatchLevel& level : levels) level.stop_step_rad = level.stop_step_m / lever_m;
}

}  // namespace

std::vector<std::string> localizer_names() { return {std::begin(kNames), std::end(kNames)}; }

std::string_view localizer_name(LocalizerKind kind) {
  return kNames[static_cast<std::size_t>(kind)];
}

LocalizerOptions localizer_options(LocalizerKind kind, int coarse_cells) {
  constexpr double kSearch_m = 1.25;  // starts of "Measured error" are at most a metre off
  return {.is_annealed = kind != LocalizerKind::kPlain,
          .search_m = kind == LocalizerKind::kSearching ? kSearch_m : 0.0,
          .coarse_cells = coarse_cells};
}

LocalizerOptions options_for_samples(int coarse_cells) {
  LocalizerOptions options = localizer_options(LocalizerKind::kSearching, coarse_cells);
  options.lead_stop_m = 0.05;
  options.loose_below = 0.25;
  options.fewest_lead = 128;
  options.has_quick_steps = true;
  return options;
}

LocalizerOptions localizer_named(std::string_view name, int coarse_cells) {
  for (const LocalizerKind kind : {LocalizerKind::kPlain, LocalizerKind::kAnnealed}) {
    if (name == localizer_name(kind)) return localizer_options(kind, coarse_cells);
  }
  return localizer_options(LocalizerKind::kSearching, coarse_cells);
}

Localizer make_localizer(const NdtMap& map, const LocalizerOptions& options) {
  check(options);
  Localizer localizer{options, {}};
  const bool has_coarse = options.coarse_cells > 1;
  const NdtMap coarse = has_coarse ? coarse_map(map, options.coarse_cells) : NdtMap{};
  const NdtMap& widest = has_coarse ? coarse : map;
  for (std::size_t number = 0; number < level_count(options); ++number) {
    const NdtMap& of_level = is_of_map(number, options) ? map : widest;
    localizer.levels.push_back({std::make_shared<const MatchGrid>(make_match_grid(
                                    of_level, information_of(number, options, widest.cell_m))),
                                settings_of(number, options)});
  }
  return localizer;
}

LocalizerBuilder::LocalizerBuilder(const NdtMap& map, const LocalizerOptions& options)
    : map_(map), localizer_{options, {}} {
  check(options);
}

bool LocalizerBuilder::step() {
  constexpr std::size_t kNdsAtOnce = 256;
  constexpr std::size_t kRecordsAtOnce = 1024;
  const LocalizerOptions& options = localizer_.options;
  const std::size_t number = localizer_.levels.size();
  if (number == level_count(options)) return true;
  if (options.coarse_cells > 1 && coarse_ == nullptr) {
    coarse_ = std::make_unique<const NdtMap>(coarse_map(map_, options.coarse_cells));
    return false;
  }
  const NdtMap& widest = coarse_ == nullptr ? map_ : *coarse_;
  const NdtMap& of_level = is_of_map(number, options) ? map_ : widest;
  if (!grid_) {
    grid_.emplace(of_level.cell_m, information_of(number, options, widest.cell_m));
    grid_->reserve(of_level.nds.size());
    added_count_ = 0;
  }
  if (added_count_ < of_level.nds.size()) {
    const std::size_t count = std::min(kNdsAtOnce, of_level.nds.size() - added_count_);
    grid_->add(std::span(of_level.nds).subspan(added_count_, count));
    added_count_ += count;
    return false;
  }
  if (!grid_->fill(kRecordsAtOnce)) return false;
  MatchGrid grid = grid_->finish();
  grid_.reset();
  keep_for_kernels(grid);
  localizer_.levels.push_back(
      {std::make_shared<const MatchGrid>(std::move(grid)), settings_of(number, options)});
  return number + 1 == level_count(options);
}

Localizer localizer_for_samples(const Localizer& own, const NdtMap& map, int coarse_cells) {
  const LocalizerOptions options = options_for_samples(coarse_cells);
  if (!own.options.is_annealed) return make_localizer(map, options);
  Localizer localizer{options, own.levels};
  for (std::size_t i = 0; i < localizer.levels.size(); ++i) {
    localizer.levels[i].settings = annealed_level(i, localizer.levels.size(), options);
  }
  return localizer;
}

ScanForMatch make_scan_for_match(const Localizer& localizer,
                                 std::span<const Eigen::Vector3d> points_m) {
  return make_scan_for_match(points_m, lead_stride(localizer, points_m.size()));
}

std::size_t lead_stride(const Localizer& localizer, std::size_t point_count) {
  if (!localizer.options.is_annealed) return 1;
  return std::clamp(point_count / localizer.options.fewest_lead, std::size_t{1}, kThinStride);
}

ScanForMatch make_scan_for_match(const Localizer& localizer, ScanCutter& cutter, const Scan& scan,
                                 const SensorProfile& sensor, const ScanCut& cut) {
  std::vector<Eigen::Vector3d> points_m =
      cutter.cut(scan.points_m, cut, return_stride(cut, sensor.azimuth_step_deg));
  for (Eigen::Vector3d& point_m : points_m) point_m = sensor.T_vehicle_lidar * point_m;
  return make_scan_for_match(localizer, points_m);
}

MatchResult localize(const Localizer& localizer, ScanForMatch& scan, const Pose& T_map_start,
                     const MatchOptions& options, SharedClimbs* shared) {
  const std::size_t count = localizer.levels.size();
  if (count == 1) return match(*localizer.levels[0].grid, scan, T_map_start, options);
  SIGHTLINE_CHECK(count > 0 && count <= kMostLevels);
  std::array<MatchLevel, kMostLevels> levels;
  for (std::size_t i = 0; i < count; ++i) {
    levels[i] = localizer.levels[i].settings;
    levels[i].grid = localizer.levels[i].grid.get();
  }
  limit_steps(options, levels[count - 1]);
  const LocalizerOptions& how = localizer.options;
  if (how.is_annealed) stop_where_points_rest(scan, std::span(levels).first(count));
  const std::span<const MatchLevel> all = std::span(levels).first(count);
  if (how.search_m <= 0.0) return match(all, scan, T_map_start, options);
  const double search_m = std::min(how.search_m, options.search_m);
  const OptimumSearch search{all, search_m, how.loose_below, options};
  return search_optimum(search, T_map_start, scan, shared);
}

MatchResult settle(const Localizer& localizer, ScanForMatch& scan, const Pose& T_map_start,
                   const MatchOptions& options) {
  const Localizer::Level& finest = localizer.levels.back();
  MatchLevel level = finest.settings;
  level.grid = finest.grid.get();
  limit_steps(options, level);
  if (localizer.options.is_annealed) stop_where_points_rest(scan, std::span(&level, 1));
  return match(std::span(&level, 1), scan, T_map_start, options);
}

NdtMap coarse_map(const NdtMap& map, int factor) {
  SIGHTLINE_CHECK(factor >= 1);
  NdtMap coarse = map;
  coarse.cell_m = factor * map.cell_m;
  while (!is_tiling(coarse.cell_m, coarse.tile_m)) coarse.tile_m += map.tile_m;
  std::map<std::pair<TileKey, CellKey>, CellMoments> cells;
  for (const Nd& nd : map.nds) {
    const CellKey key{floor_divide(nd.key.x, factor), floor_divide(nd.key.y, factor),
                      floor_divide(nd.key.z, factor)};
    cells[{tile_of(key, coarse.cell_m, coarse.tile_m), key}].add(
        nd, nd.mean_m - cell_centre_m(key, coarse.cell_m));
  }
  coarse.nds.clear();
  for (const auto& [place, moments] : cells) {
    coarse.nds.push_back(undecomposed_nd(place.second, moments, coarse.cell_m));
  }
  decompose(coarse.nds);
  return coarse;
}

}  // namespace sightline
