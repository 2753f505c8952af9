#include "passes/localize/calibrate_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "passes/localize/area_localizers.h"
#include "passes/localize/track_matcher.h"
#include "passes/matching/look_plan.h"
#include "passes/matching/match_starts.h"
#include "passes/pass/default_looks.h"
#include "passes/pass/scan_selection.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

constexpr std::size_t kLeastScans = 10;

struct Setup {
  const CalibratePlanOptions& options;
  const DriveOnMap& placed;
  const RangeTable& looks;
  AreaLocalizers& localizers;
};

bool is_even_step(std::int64_t step_ns) { return step_ns > 0 && step_ns <= kLongestStep_ns; }

// Where the two scans before it predict the vehicle; none across a pause or another piece.
std::optional<Pose> predicted_at(const Setup& setup, std::size_t position) {
  if (position < 2) return std::nullopt;
  const std::int64_t now_ns = setup.placed.step_ns(position);
  const std::int64_t before_ns = setup.placed.step_ns(position - 1);
  const auto pose_at = [&](std::size_t at) -> const TrajectoryPose& {
    return setup.placed.in_map.poses[setup.placed.scans[at]];
  };
  const TrajectoryPose& first = pose_at(position - 2);
  const TrajectoryPose& last = pose_at(position - 1);
  const bool is_even = is_even_step(now_ns) && is_even_step(before_ns) &&
                       first.piece == last.piece && last.piece == pose_at(position).piece;
  if (!is_even) return std::nullopt;
  const Pose motion = first.T_map_vehicle.inverse(Eigen::Isometry) * last.T_map_vehicle;
  const double now_s = static_cast<double>(now_ns) * 1e-9;
  const double before_s = static_cast<double>(before_ns) * 1e-9;
  return predicted_pose(last.T_map_vehicle, motion, now_s / before_s);
}

constexpr double kAlways = -std::numeric_limits<double>::infinity();
constexpr double kNever = std::numeric_limits<double>::infinity();

// One scan, and what its matches share.
struct ScanToTry {
  const Localizer& localizer;
  const SensorProfile& sensor;
  const Scan& scan;
  const Pose& T_map_predicted;
  const Eigen::Vector3d& reference_m;

  [[nodiscard]] TriedResult result(const MatchResult& match) const {
    return {(match.T_map_sensor.translation() - reference_m).norm(),
            static_cast<double>(match.work)};
  }
  [[nodiscard]] PlannedMatch match(LookPlan plan, double doubt_above, LookMemory& memory) const {
    plan.doubt_above = doubt_above;
    return localize_in_looks({localizer, sensor, plan}, scan, {T_map_predicted, true}, memory);
  }
};

// None where the first look finds nothing.
std::optional<TriedScan> try_looks(const ScanToTry& scan, const LookPlan& usual, const Look& look,
                                   LookMemory& memory) {
  const LookPlan plan = plan_at(usual, look);
  const PlannedMatch first = scan.match(plan, kNever, memory);
  if (!std::isfinite(first.doubt)) return std::nullopt;
  LookPlan other = plan;
  other.second = cheaper_second_look();
  LookPlan of_look = plan;
  of_look.first = look;
  return TriedScan{first.doubt, scan.result(first.match),
                   scan.result(scan.match(other, kAlways, memory).match),
                   scan.result(scan.match(plan, kAlways, memory).match),
                   scan.result(scan.match(of_look, kNever, memory).match)};
}

Result<std::optional<TriedScan>> try_scan(const Setup& setup, const LookPlan& usual,
                                          std::size_t position, LookMemory& memory) {
  const std::optional<Pose> T_map_predicted = predicted_at(setup, position);
  if (!T_map_predicted) return std::optional<TriedScan>();
  const std::optional<std::size_t> site = setup.placed.site_near(*T_map_predicted);
  if (!site) return std::optional<TriedScan>();
  const Look& look = setup.looks.looks[setup.looks.range(*site, 0)];
  const Drive& drive = setup.placed.drive;
  const std::size_t scan = setup.placed.scans[position];
  SIGHTLINE_ASSIGN(const Scan points, drive.store->read(scan));
  SIGHTLINE_ASSIGN(const std::shared_ptr<const AreaLocalizer> area,
                   setup.localizers.at(T_map_predicted->translation()));
  const Eigen::Vector3d reference_m = setup.placed.in_map.poses[scan].T_map_vehicle.translation();
  return try_looks({area->of_samples, drive.sensor, points, *T_map_predicted, reference_m}, usual,
                   look, memory);
}

// Consecutive scans that are looked at together.
constexpr std::size_t kScansInPart = 64;

// Of the scans from `first` on, in their order.
Result<std::vector<TriedScan>> try_part(const Setup& setup, const LookPlan& usual,
                                        std::size_t first) {
  std::vector<TriedScan> tried;
  const std::size_t end = std::min(first + kScansInPart, setup.placed.scans.size());
  for (std::size_t position = first; position < end; ++position) {
    LookMemory memory{LookCutter(setup.options.matching.leaf_m), {}};
    SIGHTLINE_ASSIGN(const std::optional<TriedScan> scan, try_scan(setup, usual, position, memory));
    if (scan) tried.push_back(*scan);
  }
  return tried;
}

// What decides the results of a part besides what `street` names: its scans and the two before
// them, where and when they were, and the NDs that they may meet.
std::optional<Digest> content_of(const Setup& setup, const MatchContents& contents,
                                 const Digest& street, std::size_t first) {
  std::vector<std::optional<std::size_t>> scans;
  ByteWriter writer;
  const std::size_t end = std::min(first + kScansInPart, setup.placed.scans.size());
  for (std::size_t i = first - std::min<std::size_t>(first, 2); i < end; ++i) {
    const std::size_t scan = setup.placed.scans[i];
    scans.emplace_back(scan);
    writer.put(setup.placed.drive.scans[scan].stamp_ns);
    writer.put(setup.placed.in_map.poses[scan].piece);
  }
  const std::optional<Digest> matches = contents.of(scans);
  if (!matches) return std::nullopt;
  DigestBuilder builder;
  builder.add(street);
  builder.add(*matches);
  builder.add(writer.bytes());
  return builder.finish();
}

Result<std::vector<TriedScan>> try_scans(PassContext& ctx, const Setup& setup,
                                         const LookPlan& usual, const MatchContents& contents,
                                         const Digest& street) {
  RecordWork<std::vector<TriedScan>> work;
  work.count = (setup.placed.scans.size() + kScansInPart - 1) / kScansInPart;
  work.content = [&](std::size_t part) {
    return content_of(setup, contents, street, part * kScansInPart);
  };
  work.make = [&](std::size_t part, int /*threads*/) {
    return try_part(setup, usual, part * kScansInPart);
  };
  work.order = PartOrder::kApart;
  SIGHTLINE_ASSIGN(const std::vector<std::vector<TriedScan>> found,
                   make_parts(ctx, std::move(work)));
  std::vector<TriedScan> tried;
  for (const std::vector<TriedScan>& of_part : found) {
    tried.insert(tried.end(), of_part.begin(), of_part.end());
  }
  return tried;
}

double doubted_share(const std::vector<double>& ascending, double doubt_above) {
  const auto above = ascending.end() - std::ranges::upper_bound(ascending, doubt_above);
  return ascending.empty() ? 0.0
                           : static_cast<double>(above) / static_cast<double>(ascending.size());
}

// Ascending.
std::vector<double> doubts_of_good(const CalibratePlanOptions& options,
                                   const std::vector<TriedScan>& scans) {
  std::vector<double> good;
  for (const TriedScan& scan : scans) {
    if (scan.first.error_m <= options.good_m) good.push_back(scan.doubt);
  }
  std::ranges::sort(good);
  return good;
}

}  // namespace

double raised_threshold(const CalibratePlanOptions& options, const LookPlan& plan,
                        const std::vector<TriedScan>& scans) {
  const std::vector<double> good = doubts_of_good(options, scans);
  if (good.size() < kLeastScans) return plan.doubt_above;
  const auto kept = static_cast<std::size_t>(
      std::ceil((1.0 - options.doubted_share) * static_cast<double>(good.size())));
  double threshold = good[std::max<std::size_t>(kept, 1) - 1];
  for (const TriedScan& scan : scans) {
    if (scan.first.error_m <= plan.limit_m) continue;
    threshold = std::min(threshold, std::nextafter(scan.doubt, kAlways));
  }
  return std::max(plan.doubt_above, threshold);
}

bool is_cheaper_as_good(const CalibratePlanOptions& options, const LookPlan& plan,
                        const std::vector<TriedScan>& scans) {
  constexpr std::size_t kLeastDoubted = 20;
  std::size_t doubted = 0;
  std::size_t good_by_cheaper = 0;
  std::size_t good_by_own = 0;
  for (const TriedScan& scan : scans) {
    if (scan.doubt <= plan.doubt_above) continue;
    ++doubted;
    good_by_cheaper += scan.with_cheaper.error_m <= options.good_m ? 1 : 0;
    good_by_own += scan.with_own.error_m <= options.good_m ? 1 : 0;
  }
  return doubted >= kLeastDoubted && good_by_cheaper >= good_by_own;
}

bool is_dearer_than_looks(const LookPlan& plan, const std::vector<TriedScan>& scans) {
  constexpr double kMoreWork = 1.5;
  if (scans.size() < kLeastScans) return false;
  const bool is_own_second = plan.second != cheaper_second_look();
  double plan_work = 0.0;
  double look_work = 0.0;
  std::size_t plan_held = 0;
  std::size_t look_held = 0;
  for (const TriedScan& scan : scans) {
    const TriedResult& by_both = is_own_second ? scan.with_own : scan.with_cheaper;
    const TriedResult& by_plan = scan.doubt > plan.doubt_above ? by_both : scan.first;
    plan_work += by_plan.work;
    look_work += scan.look.work;
    plan_held += by_plan.error_m <= plan.limit_m ? 1 : 0;
    look_held += scan.look.error_m <= plan.limit_m ? 1 : 0;
  }
  return look_held >= plan_held && plan_work > kMoreWork * look_work;
}

std::vector<OptionField> option_fields(CalibratePlanOptions& options) {
  return with_matching(
      {number("doubted_share", options.doubted_share,
              "while tracking: allowed share of good first looks that trigger a second look", 0.0,
              1.0),
       reach_option(options.reach_m)},
      options.matching);
}

Result<CalibratedPlan> calibrate_plan(PassContext& ctx, const CalibratePlanOptions& options,
                                      const Drive& drive, const Trajectory& trajectory,
                                      const TiledNds& nds, const Sites& sites,
                                      const ByFamily<RangeTable>& ranges) {
  SIGHTLINE_ASSIGN(const DriveOnMap placed,
                   place_on_map(drive, trajectory, nds, sites, ranges.ranges, options.reach_m,
                                options.matching.scans));
  CalibratedPlan calibrated;
  if (!ranges.samples) return calibrated;
  calibrated.plan = usual_plan();
  AreaLocalizers localizers(nds, {LocalizerKind::kSearching, options.matching.coarse_cells,
                                  drive.sensor.max_range_m, ctx.threads});
  const Setup setup{options, placed, *ranges.samples, localizers};
  SIGHTLINE_ASSIGN(TileDigests tiles, digests_of(nds));
  const MatchContents contents(drive, placed.in_map, std::move(tiles), drive.sensor.max_range_m);
  DigestBuilder street;
  street.add(to_bytes(sites));
  street.add(to_bytes(ranges));
  SIGHTLINE_ASSIGN(const std::vector<TriedScan> tried,
                   try_scans(ctx, setup, *calibrated.plan, contents, street.finish()));
  const std::vector<double> good = doubts_of_good(options, tried);
  LookPlan& plan = *calibrated.plan;
  calibrated.scan_count = static_cast<std::uint32_t>(tried.size());
  calibrated.good_count = static_cast<std::uint32_t>(good.size());
  calibrated.learnt_doubted_share = doubted_share(good, plan.doubt_above);
  plan.doubt_above = raised_threshold(options, plan, tried);
  calibrated.doubted_share = doubted_share(good, plan.doubt_above);
  if (is_cheaper_as_good(options, plan, tried)) plan.second = cheaper_second_look();
  if (is_dearer_than_looks(plan, tried)) {
    ctx.inform(
        "no plan: on this drive it needs more work than the map's looks, which keep as many "
        "scans within the limit");
    calibrated.plan.reset();
  }
  return calibrated;
}

}  // namespace sightline
