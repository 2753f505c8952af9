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

constexpr std::size_t kLeastGoodScans = 10;

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

// The plan at a place; none where no site is near.
std::optional<LookPlan> plan_near(const Setup& setup, const LookPlan& usual,
                                  const Pose& T_map_vehicle) {
  const std::optional<std::size_t> site = setup.placed.site_near(T_map_vehicle);
  if (!site) return std::nullopt;
  LookPlan plan = plan_at(usual, setup.looks.looks[setup.looks.range(*site, 0)]);
  plan.doubt_above = std::numeric_limits<double>::infinity();  // the first look alone
  return plan;
}

Result<std::optional<FirstLook>> look_first(const Setup& setup, const LookPlan& usual,
                                            std::size_t position, LookMemory& memory) {
  const std::optional<Pose> T_map_predicted = predicted_at(setup, position);
  if (!T_map_predicted) return std::optional<FirstLook>();
  const std::optional<LookPlan> plan = plan_near(setup, usual, *T_map_predicted);
  if (!plan) return std::optional<FirstLook>();
  const Drive& drive = setup.placed.drive;
  const std::size_t scan = setup.placed.scans[position];
  SIGHTLINE_ASSIGN(const Scan points, drive.store->read(scan));
  SIGHTLINE_ASSIGN(const std::shared_ptr<const AreaLocalizer> area,
                   setup.localizers.at(T_map_predicted->translation()));
  const PlannedMatch found = localize_in_looks({area->of_samples, drive.sensor, *plan}, points,
                                               {*T_map_predicted, true}, memory);
  if (!std::isfinite(found.doubt)) return std::optional<FirstLook>();
  const Pose& T_map_reference = setup.placed.in_map.poses[scan].T_map_vehicle;
  return std::optional<FirstLook>(FirstLook{
      found.doubt, (found.T_map_first.translation() - T_map_reference.translation()).norm()});
}

// Consecutive scans that are looked at together.
constexpr std::size_t kScansInPart = 64;

// Of the scans from `first` on, in their order.
Result<std::vector<FirstLook>> look_first(const Setup& setup, const LookPlan& usual,
                                          std::size_t first) {
  std::vector<FirstLook> looks;
  const std::size_t end = std::min(first + kScansInPart, setup.placed.scans.size());
  for (std::size_t position = first; position < end; ++position) {
    LookMemory memory{LookCutter(setup.options.matching.leaf_m), {}};
    SIGHTLINE_ASSIGN(const std::optional<FirstLook> look,
                     look_first(setup, usual, position, memory));
    if (look) looks.push_back(*look);
  }
  return looks;
}

// What decides the looks of a part besides what `street` names: its scans and the two before them,
// where and when they were, and the NDs that they may meet.
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

Result<std::vector<FirstLook>> first_looks(PassContext& ctx, const Setup& setup,
                                           const LookPlan& usual, const MatchContents& contents,
                                           const Digest& street) {
  RecordWork<std::vector<FirstLook>> work;
  work.count = (setup.placed.scans.size() + kScansInPart - 1) / kScansInPart;
  work.content = [&](std::size_t part) {
    return content_of(setup, contents, street, part * kScansInPart);
  };
  work.make = [&](std::size_t part, int /*threads*/) {
    return look_first(setup, usual, part * kScansInPart);
  };
  work.order = PartOrder::kApart;
  SIGHTLINE_ASSIGN(const std::vector<std::vector<FirstLook>> found,
                   make_parts(ctx, std::move(work)));
  std::vector<FirstLook> looks;
  for (const std::vector<FirstLook>& of_part : found) {
    looks.insert(looks.end(), of_part.begin(), of_part.end());
  }
  return looks;
}

double doubted_share(const std::vector<double>& ascending, double doubt_above) {
  const auto above = ascending.end() - std::ranges::upper_bound(ascending, doubt_above);
  return ascending.empty() ? 0.0
                           : static_cast<double>(above) / static_cast<double>(ascending.size());
}

// Ascending.
std::vector<double> doubts_of_good(const CalibratePlanOptions& options,
                                   const std::vector<FirstLook>& looks) {
  std::vector<double> good;
  for (const FirstLook& look : looks) {
    if (look.error_m <= options.good_m) good.push_back(look.doubt);
  }
  std::ranges::sort(good);
  return good;
}

}  // namespace

double raised_threshold(const CalibratePlanOptions& options, const LookPlan& plan,
                        const std::vector<FirstLook>& looks) {
  const std::vector<double> good = doubts_of_good(options, looks);
  if (good.size() < kLeastGoodScans) return plan.doubt_above;
  const auto kept = static_cast<std::size_t>(
      std::ceil((1.0 - options.doubted_share) * static_cast<double>(good.size())));
  double threshold = good[std::max<std::size_t>(kept, 1) - 1];
  for (const FirstLook& look : looks) {
    if (look.error_m <= plan.limit_m) continue;
    threshold =
        std::min(threshold, std::nextafter(look.doubt, -std::numeric_limits<double>::infinity()));
  }
  return std::max(plan.doubt_above, threshold);
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
  SIGHTLINE_ASSIGN(const std::vector<FirstLook> looks,
                   first_looks(ctx, setup, *calibrated.plan, contents, street.finish()));
  const std::vector<double> good = doubts_of_good(options, looks);
  LookPlan& plan = *calibrated.plan;
  calibrated.scan_count = static_cast<std::uint32_t>(looks.size());
  calibrated.good_count = static_cast<std::uint32_t>(good.size());
  calibrated.learnt_doubted_share = doubted_share(good, plan.doubt_above);
  plan.doubt_above = raised_threshold(options, plan, looks);
  calibrated.doubted_share = doubted_share(good, plan.doubt_above);
  return calibrated;
}

}  // namespace sightline
