#include "passes/localize/simulate_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "formats/base/units.h"
#include "formats/geometry.h"
#include "passes/localize/area_localizers.h"
#include "passes/localize/measure_site.h"
#include "passes/localize/measured_parts.h"
#include "passes/pass/tile_digests.h"
#include "passes/rays/surface_caster.h"

// Every factor of a virtual scan but this one sees the very surface that the map was made of. What
// a vehicle meets differs: the sensor is noisy, traffic hides a part of the view, and what stands
// there is rougher than the points tell. So each patch is laid a little off once for the whole map,
// as if it had been surveyed again, and each scan is disturbed by chance that its site decides.

namespace sightline {
namespace {

constexpr std::uint64_t kReliefSeed = 0x72656c696566ULL;
constexpr std::uint64_t kScanSeed = 0x7363616eULL;

// More than half a patch, the cells around a point, the noise, the start and the mounting.
constexpr double kBeside_m = 16.0;

constexpr const char* kDrive = "simulated";

Result<void> check_inputs(const SimulateErrorOptions& options, const TiledSurface& surface,
                          const TiledNds& nds, const Sites& sites) {
  constexpr const char* kPlace = "pass simulate-error";
  if (!(nds.head().frame == sites.frame && surface.head().frame == sites.frame)) {
    return Error{ErrorCode::kMismatchedInputs, "map, surface and sites are in different frames", "",
                 kPlace};
  }
  if (nds.row_count() == 0) {
    return Error{ErrorCode::kEmptyMap, "the map has no valid cell to match with", "", kPlace};
  }
  if (options.matching.localizer == LocalizerKind::kPclNdt) {
    return Error{
        ErrorCode::kBadValue,
        "pcl-ndt needs a recorded drive: add one under localization, or choose another localizer",
        "", kPlace};
  }
  return {};
}

// The same patch, surveyed on another day: off along its normal by chance of its own.
void survey_another_day(double relief_m, std::uint64_t seed, SurfacePatch& patch) {
  const std::uint64_t cell = hash_of(patch.key);
  const auto size = static_cast<std::uint64_t>(std::llround(1e3 * patch.half_side_m));
  Random random(mix(mix(seed, kReliefSeed), cell << 16 ^ size));
  patch.centre_m += relief_m * random.normal() * patch.normal;
}

// Beam by beam from below, and around in each: rays that are cast together lie close together.
std::vector<Eigen::Vector3d> directions_of(const SensorProfile& sensor) {
  const auto azimuth_count = static_cast<int>(std::lround(360.0 / sensor.azimuth_step_deg));
  std::vector<Eigen::Vector3d> directions;
  for (const double elevation_deg : sensor.beam_elevations_deg) {
    for (int i = 0; i < azimuth_count; ++i) {
      // Half a step off, so that no ray runs along an axis of the map.
      const double azimuth_rad = (i + 0.5) * sensor.azimuth_step_deg * kRadPerDeg;
      directions.push_back(direction_of(azimuth_rad, elevation_deg * kRadPerDeg));
    }
  }
  return directions;
}

// What a sensor at a site returns, in its own frame.
class ScanMaker {
 public:
  ScanMaker(const SimulateErrorOptions& options, const SensorProfile& sensor,
            std::vector<Eigen::Vector3d> directions)
      : options_(options), sensor_(sensor), directions_(std::move(directions)) {
    for (const Eigen::Vector3d& direction : directions_) {
      azimuth_rad_.push_back(portable_atan2(direction.y(), direction.x()));
    }
  }

  [[nodiscard]] const std::vector<Eigen::Vector3d>& directions() const { return directions_; }

  // The middle of what traffic hides.
  [[nodiscard]] static double hidden_rad(std::uint64_t seed) {
    Random random(seed);
    return drawn_azimuth_rad(random);
  }
  [[nodiscard]] bool is_hidden(std::size_t ray, double hidden_rad) const {
    const double off_rad = std::remainder(azimuth_rad_[ray] - hidden_rad, 2.0 * std::numbers::pi);
    return std::abs(off_rad) < 0.5 * options_.hidden_deg * kRadPerDeg;
  }

  // Of distances that are NaN where a ray is hidden.
  [[nodiscard]] Scan scan(const Site& site, std::span<const double> distance_m,
                          std::uint64_t seed) const {
    const Eigen::Matrix3d R_lidar_map =
        (site.T_map_vehicle.linear() * sensor_.T_vehicle_lidar.linear()).transpose();
    Random random(seed);
    drawn_azimuth_rad(random);
    Scan scan;
    // As sensors turn: azimuth by azimuth, beam by beam.
    const std::size_t beam_count = sensor_.beam_elevations_deg.size();
    const std::size_t azimuth_count = directions_.size() / beam_count;
    for (std::size_t turn = 0; turn < directions_.size(); ++turn) {
      const std::size_t i = turn % beam_count * azimuth_count + turn / beam_count;
      // As many numbers for each ray, whatever becomes of it: sites that see the same hear the
      // same.
      const bool is_missing = random.uniform() < options_.missing_share;
      const double noise_m = options_.range_noise_m * random.normal();
      if (is_missing || !std::isfinite(distance_m[i])) continue;
      scan.points_m.emplace_back((distance_m[i] + noise_m) * (R_lidar_map * directions_[i]));
    }
    return scan;
  }

 private:
  static double drawn_azimuth_rad(Random& random) {
    return random.uniform(-std::numbers::pi, std::numbers::pi);
  }

  const SimulateErrorOptions& options_;
  const SensorProfile& sensor_;
  std::vector<Eigen::Vector3d> directions_;
  std::vector<double> azimuth_rad_;
};

// As far as any look reaches that the sensor does.
double reach_m(const MeasureErrorOptions& matching, const SensorProfile& sensor) {
  double longest_m = matching.ranges_m.back();
  for (const Look& look : matching.looks) longest_m = std::max(longest_m, look.range_m);
  return std::min(longest_m, sensor.max_range_m);
}

// Without rows.
ByFamily<MeasuredError> empty_result(const MeasureErrorOptions& matching, double cell_m,
                                     std::size_t site_count) {
  MeasuredError simulated;
  simulated.drive = kDrive;
  simulated.matching = matching_card(matching, cell_m);
  simulated.matching.site_step = 1;
  simulated.reference = ErrorReference::kSimulated;
  simulated.looks = every_return_at(matching.ranges_m);
  MatchStarts starts = match_starts_of(matching);
  simulated.offsets = std::move(starts.acquiring);
  simulated.tracking_offsets = std::move(starts.tracking);
  for (std::size_t site = 0; site < site_count; ++site) {
    simulated.scan_of_site.push_back(static_cast<std::int64_t>(site));
  }
  ByFamily<MeasuredError> both(simulated);
  if (!matching.looks.empty()) {
    both.samples = std::move(simulated);
    both.samples->looks = matching.looks;
  }
  return both;
}

std::vector<std::vector<std::size_t>> sites_of(const std::vector<SiteBlock>& blocks) {
  std::vector<std::vector<std::size_t>> sites;
  for (const SiteBlock& block : blocks) sites.push_back(block.sites);
  return sites;
}

// Of one site and the looks of a family.
void measure_into(const MatchStarts& starts, const ReferencedScan& scan, std::size_t site,
                  SiteLocalizer& localizer, MeasuredError& simulated) {
  MeasuredRows of_site;
  measure_scan(starts, simulated.looks, scan, localizer, of_site);
  const auto first = static_cast<std::ptrdiff_t>(simulated.shape().size(site));
  const auto tracking_count = static_cast<std::ptrdiff_t>(starts.tracking.size());
  std::ranges::copy(of_site.rows, simulated.rows.begin() + first);
  std::ranges::copy(of_site.tracking_ends,
                    simulated.tracking_ends.begin() + first * tracking_count);
}

}  // namespace

std::vector<OptionField> option_fields(SimulateErrorOptions& options) {
  return with_matching(
      {number("range_noise_m", options.range_noise_m,
              "range noise of simulated returns, standard deviation, m", 0.0, 1.0),
       number("hidden_deg", options.hidden_deg,
              "azimuth that traffic occludes in a simulated scan, degrees", 0.0, 360.0),
       number("missing_share", options.missing_share, "share of missing returns", 0.0, 0.99),
       number("relief_m", options.relief_m,
              "difference of the surface on another day, standard deviation, m", 0.0, 1.0)},
      options.matching);
}

Result<ByFamily<StoredTable<MeasuredError>>> simulate_error(PassContext& ctx,
                                                            const SimulateErrorOptions& options,
                                                            const TiledSurface& surface,
                                                            const TiledNds& nds, const Sites& sites,
                                                            const SensorProfile& sensor) {
  SIGHTLINE_TRY(check_inputs(options, surface, nds, sites));
  SIGHTLINE_TRY(validate(options.matching.tracking));
  const MeasureErrorOptions& matching = options.matching;
  const MatchStarts starts = match_starts_of(matching);
  const LocalizerChoice choice{matching.localizer, matching.coarse_cells, matching.leaf_m,
                               matching.every_return};
  const ScanMaker maker(options, sensor, directions_of(sensor));
  const RayFan whole{maker.directions(), sensor.min_range_m, reach_m(matching, sensor),
                     AzimuthView(sensor)};
  AreaLocalizers localizers(nds, {matching.localizer, matching.coarse_cells, whole.far_m, 1});
  const SiteCaster caster(surface, sites, whole.far_m, [&](SurfacePatch& patch) {
    survey_another_day(options.relief_m, ctx.seed, patch);
  });
  const ByFamily<MeasuredError> empty =
      empty_result(matching, nds.head().cell_m, sites.sites.size());
  // Blocks one after another, so that one scene at a time is in memory; sites side by side.
  const auto fill = [&](std::size_t part, ByFamily<MeasuredError>& rows) -> Result<void> {
    const SiteBlock& block = caster.blocks()[part];
    const auto seed_of = [&](std::size_t i) {
      return mix(mix(ctx.seed, kScanSeed), block.sites[i]);
    };
    std::vector<double> hidden_rad;
    for (std::size_t i = 0; i < block.sites.size(); ++i) {
      hidden_rad.push_back(ScanMaker::hidden_rad(seed_of(i)));
    }
    RayFan fan = whole;
    fan.wants = [&](std::size_t i, std::size_t ray) {
      return !maker.is_hidden(ray, hidden_rad[i]);
    };
    std::vector<Result<void>> taken(block.sites.size());
    const auto take = [&](std::size_t i, std::span<const double> distance_m) {
      const Site& at = sites.sites[block.sites[i]];
      const Scan scan = maker.scan(at, distance_m, seed_of(i));
      const Result<std::shared_ptr<const AreaLocalizer>> area =
          localizers.at(at.T_map_vehicle.translation());
      if (!area) {
        taken[i] = area.error();
        return;
      }
      const AreaLocalizer& here = **area;
      const std::unique_ptr<SiteLocalizer> localizer = make_site_localizer(
          {choice, sensor, here.for_pcl, here.own, here.of_samples, &here.structures});
      visit_families(rows, [&](MeasuredError& of_family) {
        measure_into(starts, {scan, at.T_map_vehicle, at.T_map_vehicle}, i, *localizer, of_family);
      });
    };
    SIGHTLINE_ASSIGN(const BlockScene scene, caster.scene(block));
    scene.cast(fan, ctx.threads, take);
    for (const Result<void>& of_site : taken) SIGHTLINE_TRY(of_site);
    return {};
  };
  SIGHTLINE_ASSIGN(const TileDigests patches, digests_of(surface));
  SIGHTLINE_ASSIGN(const TileDigests nd_digests, digests_of(nds));
  const auto content = [&](std::size_t part) -> std::optional<Digest> {
    ByteWriter writer;
    encode(sensor, writer);
    std::vector<Eigen::Vector3d> places_m;
    for (const std::size_t site : caster.blocks()[part].sites) {
      writer.put<std::uint64_t>(site);  // its seed
      put_place(sites.sites[site], writer);
      places_m.push_back(sites.sites[site].p_map_m);
    }
    DigestBuilder builder;
    builder.add(writer.bytes());
    builder.add(patches.within(box_around(places_m, whole.far_m + kBeside_m)));
    builder.add(
        nd_digests.within(box_around(places_m, whole.far_m + kFarthestFound_m + kBeside_m)));
    return builder.finish();
  };
  return fill_in_parts(ctx, {sites_of(caster.blocks()), fill, content}, /*at_once=*/1, empty);
}

}  // namespace sightline
