#include "tests/formats/map/random_map.h"

#include <algorithm>
#include <limits>
#include <map>

#include "formats/base/random.h"
#include "formats/map/container/small_nd.h"

namespace sightline {
namespace {

NdtMap random_ndt(const RandomMapOptions& options, Random& random) {
  NdtMap ndt;
  ndt.frame.origin_world_m = {64.0 * 7000.0, -64.0 * 3.0, 0.0};
  ndt.tile_m = options.tile_m;
  ndt.point_count = 12345;
  ndt.sparse_cell_count = 6;
  ndt.degenerate_cell_count = 1;
  std::map<std::pair<TileKey, CellKey>, Nd> sorted;
  for (int i = 0; i < options.nd_count; ++i) {
    Nd nd;
    for (int axis = 0; axis < 3; ++axis) {
      nd.mean_m[axis] = random.uniform(-options.extent_m, options.extent_m);
    }
    nd.key = cell_key(nd.mean_m, ndt.cell_m);
    nd.point_count = 10 + static_cast<std::uint32_t>(random.below(1000));
    Eigen::Matrix3d root;
    for (int k = 0; k < 9; ++k) root(k / 3, k % 3) = random.normal();
    nd.covariance_m2 = 0.1 * root * root.transpose();
    decompose(nd);
    sorted[{tile_of(nd.key, ndt.cell_m, ndt.tile_m), nd.key}] = nd;
  }
  for (const auto& [key, nd] : sorted) ndt.nds.push_back(nd);
  return ndt;
}

Sites random_sites(const RandomMapOptions& options, const MapFrame& frame, Random& random) {
  Sites sites;
  sites.frame = frame;
  for (int i = 0; i < options.site_count; ++i) {
    Site site;
    const int first_of_run = i * options.run_count / options.site_count;
    site.run = static_cast<std::uint32_t>(first_of_run);
    const bool starts = i == 0 || site.run != sites.sites.back().run;
    site.s_m = starts ? 0.0 : sites.sites.back().s_m + 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double reach_m = axis < 2 ? options.extent_m : 3.0;
      site.p_map_m[axis] = random.uniform(-reach_m, reach_m);
    }
    site.T_map_vehicle.translation() = site.p_map_m - Eigen::Vector3d(0.0, 0.0, 1.8);
    site.T_map_vehicle.linear() =
        Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    sites.sites.push_back(site);
  }
  return sites;
}

PredictedError random_prediction(const RandomMapOptions& options, const std::vector<Look>& looks,
                                 Random& random) {
  PredictedError predicted;
  predicted.looks = looks;
  predicted.limits_m = options.limits_m;
  predicted.site_count = static_cast<std::uint32_t>(options.site_count);
  for (int i = 0; i < options.site_count; ++i) {
    for (std::size_t look = 0; look < looks.size(); ++look) {
      predicted.mean_m.push_back(random.uniform(0.0, 0.5));
      double probability = 0.0;
      for (std::size_t limit = 0; limit < options.limits_m.size(); ++limit) {
        probability += (1.0 - probability) * random.uniform();
        predicted.within_probability.push_back(std::min(1.0, probability));
      }
    }
    const auto is_odd = static_cast<std::size_t>(random.below(2));
    for (std::size_t look = 0; look < looks.size(); ++look) {
      predicted.extrapolated.push_back(look % 2 == is_odd ? 1 : 0);
    }
    predicted.out_of_fold.push_back(static_cast<std::uint8_t>(random.below(2)));
    predicted.has_history.push_back(static_cast<std::uint8_t>(random.below(2)));
  }
  return predicted;
}

RangeTable random_ranges(const RandomMapOptions& options, const std::vector<Look>& looks,
                         Random& random) {
  RangeTable table;
  table.looks = looks;
  table.dilation_m = 3.0;
  table.site_count = static_cast<std::uint32_t>(options.site_count);
  for (const double limit_m : options.limits_m) {
    table.promises.push_back({limit_m, "conformal", 0.8, 0.7, 0.05, 0.0, 12, 3, 6,
                              limit_m > 0.2 ? PromiseScope::kNextDrive : PromiseScope::kThisDrive,
                              limit_m > 0.2, 0.04, 0.9,
                              "at most 5 % of places miss the limit, on average"});
  }
  for (int i = 0; i < options.site_count; ++i) {
    std::uint64_t longest = looks.size() - 1;
    for (std::size_t limit = 0; limit < options.limits_m.size(); ++limit) {
      longest = random.below(longest + 1);  // a looser limit never looks further
      const bool is_longest = longest + 1 == looks.size();
      table.range_index.push_back(static_cast<std::uint8_t>(longest));
      table.flags.push_back(
          static_cast<std::uint8_t>((is_longest ? random.below(2) : 0) + 2 * random.below(2)));
      const std::size_t rules = kNamesOf<Reason>.size() - 1;
      table.reasons.push_back(static_cast<Reason>(1 + table.reasons.size() % rules));
    }
  }
  return table;
}

ModelRecord random_model(std::size_t size, Random& random) {
  ModelRecord model;
  model.encoding_version = ArtifactTraits<ErrorModel>::kVersion;
  model.card = {{"drive", "town drive 1"}, {"tree_count", "200"}};
  model.figures = {{1, CardFigureKind::kImportance_m, "tree_count", 200.0}};
  model.mean_r_squared = -0.5;
  for (std::size_t i = 0; i < size; ++i) model.bytes.push_back(std::byte(random.below(4)));
  model.digest = sha256(model.bytes);
  return model;
}

FactorTable random_factors(const RandomMapOptions& options, const std::vector<Look>& looks,
                           Random& random) {
  FactorTable factors;
  factors.looks = looks;
  factors.factors = {"feature_count", "crlb_max", "crlb_heading"};
  factors.site_count = static_cast<std::uint32_t>(options.site_count);
  factors.values.resize(factors.site_count * factors.looks.size() * factors.factors.size());
  for (double& value : factors.values) value = random.normal();
  return factors;
}

std::optional<LookPlan> random_plan(const RandomMapOptions& options, Random& random) {
  if (options.seed % 3 == 0) return std::nullopt;
  LookPlan plan;
  plan.limit_m = random.uniform(0.05, 0.3);
  plan.first = {.range_m = 60.0, .return_count = 2000, .point_count = 90, .is_by_normals = true};
  plan.first.mode = LookMode::kSettle;
  plan.second = {.range_m = 95.0, .return_count = 8000, .even_beyond_m = 20.0, .point_count = 800};
  for (double& weight : plan.test.weights) weight = random.uniform(-2.0, 2.0);
  plan.test.constant = random.uniform(-5.0, 5.0);
  plan.doubt_above = random.uniform(-2.0, 2.0);
  return plan;
}

void add_looks(const RandomMapOptions& options, Random& random, CompiledMap& map) {
  auto& [predicted, ranges, quality, factors] = map.looks.emplace();
  predicted = random_prediction(options, options.looks, random);
  predicted.out_of_fold = map.predicted.out_of_fold;
  predicted.has_history = map.predicted.has_history;
  ranges = random_ranges(options, options.looks, random);
  ranges.plan = random_plan(options, random);
  factors = random_factors(options, options.looks, random);
  factors.factors = {"crlb_max", "own_error", "match_cost"};
  quality = quality_of(predicted, ranges, nullptr);
}

// From numbers of their own, so that all else of a map is as without them.
std::vector<SiteColumn> random_columns(const RandomMapOptions& options) {
  Random random(options.seed + 1000);
  std::vector<SiteColumn> columns = {{"clearance_m", "m", {}},
                                     {"kind", "", {}, {0.0F, 1.0F, 2.0F, 3.0F}}};
  for (int i = 0; i < options.site_count; ++i) {
    const bool is_open = random.below(5) == 0;
    columns[0].values.push_back(is_open ? std::numeric_limits<float>::infinity()
                                        : static_cast<float>(random.uniform(1.0, 20.0)));
    columns[1].values.push_back(static_cast<float>(random.below(4)));
  }
  return columns;
}

void make_small(CompiledMap& map) {
  for (Nd& nd : map.ndt.nds) nd = rounded_small(nd, map.ndt.cell_m);
  decompose(std::span(map.ndt.nds));
  round_answers(map);
}

}  // namespace

CompiledMap random_map(const RandomMapOptions& options) {
  Random random(options.seed);
  CompiledMap map;
  map.map_id = "0123456789abcdef0123456789abcdef";
  map.version = "2026.1";
  map.release = 7;
  map.writer = "sightline test";
  map.ndt = random_ndt(options, random);
  map.sites = random_sites(options, map.ndt.frame, random);
  const std::vector<Look> ranges = every_return_at(options.ranges_m);
  map.predicted = random_prediction(options, ranges, random);
  map.ranges = random_ranges(options, ranges, random);
  map.sensor.beam_elevations_deg = {-15.0, 0.0, 15.0};
  map.measurement.mapping_drive = "town";
  map.measurement.mapping_scans = "even";
  map.measurement.localization_drive = "town";
  map.measurement.localization_scans = "odd";
  map.measurement.localizer = {"annealed", 3, {{"coarse_cells", "2"}, {"leaf_m", "0.5"}}};
  map.measurement.coarse_cells = 2;
  map.measurement.leaf_m = 0.5;
  map.measurement.offsets = {{0.1, 0.2, -0.1, 0.01}, {-0.5, 0.3, 0.0, -0.01}};
  map.definitions = {{"ndt-map", 1}, {"sites", 1}};
  map.model = random_model(options.model_size, random);
  map.model.localizer = map.measurement.localizer;
  map.quality = quality_of(map.predicted, map.ranges, nullptr);
  map.trajectory = TrajectoryQuality{PoseSource::kEstimated, 120, 7, 3, 0.012, 0.0009};
  map.trajectory->pieces = {{0, 1'000'000'000, 80, 79.5, {1.0, 2.0, 3.0}}};
  map.trajectory->overlap_count = 79;
  map.trajectory->median_overlap = 0.9;
  map.trajectory->least_overlap = 0.7;
  map.sharpness = Sharpness{{-1.5, 40, 0.002, 900}, SharpnessFigures{-1.25, 38, 0.003, 910}};
  map.factors = random_factors(options, ranges, random);
  if (!options.looks.empty()) add_looks(options, random, map);
  if (options.has_columns) map.columns = random_columns(options);
  map.size = options.size;
  if (map.size == MapSize::kPromise) make_small(map);
  return map;
}

}  // namespace sightline
