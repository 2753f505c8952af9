#include "passes/vehicle/sightline_localizer.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/copy_message.h"
#include "formats/base/version.h"
#include "formats/drive/look.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/look_plan.h"
#include "passes/vehicle/c_values.h"
#include "passes/vehicle/map_windows.h"
#include "passes/vehicle/match_answer.h"
#include "passes/vehicle/match_protection.h"
#include "passes/vehicle/vehicle_map.h"

// Everything that a match needs memory for lies in a Workspace. A call takes a free one and gives
// it back, so that several threads can match, and a vehicle that matches scan after scan allocates
// next to nothing.

namespace sightline {
namespace {

static_assert(SIGHTLINE_CONVERGED == static_cast<unsigned>(MatchStop::kConverged));
static_assert(SIGHTLINE_ITERATION_LIMIT == static_cast<unsigned>(MatchStop::kIterationLimit));
static_assert(SIGHTLINE_NO_POINTS == static_cast<unsigned>(MatchStop::kNoPoints));
static_assert(SIGHTLINE_NO_OVERLAP == static_cast<unsigned>(MatchStop::kNoOverlap));

constexpr double kMostCells = 0x1.0p29;  // that a start may be away from the map's origin

Look look_of(const sightline_look& look) {
  return {.range_m = look.range_m,
          .return_count = look.return_count,
          .even_beyond_m = look.even_beyond_m,
          .point_count = look.point_count,
          .is_by_normals = look.is_by_normals != 0,
          .mode = look.settles != 0 ? LookMode::kSettle : LookMode::kSearch};
}

LookPlan plan_of(const sightline_look_plan& plan) {
  LookPlan result;
  result.first = look_of(plan.first);
  result.second = look_of(plan.second);
  std::copy_n(plan.weights, kLookSigns, result.test.weights.begin());
  result.test.constant = plan.constant;
  result.doubt_above = plan.doubt_above;
  return result;
}

sightline_nd c_nd(const Nd& nd, const MapFrame& frame) {
  const Eigen::Vector3d mean_m = nd.mean_m + frame.origin_world_m;
  const Eigen::Matrix3d& c = nd.covariance_m2;
  return {{mean_m.x(), mean_m.y(), mean_m.z()},
          {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)},
          nd.point_count,
          0};
}

// All that a match needs memory for.
struct Workspace {
  Scan scan;
  LookMatcher matcher;
  LookMemory planned;
  StructureObserver observer;
};

}  // namespace
}  // namespace sightline

struct sightline_localizer {
  explicit sightline_localizer(sightline::VehicleMap opened);

  [[nodiscard]] std::unique_ptr<sightline::Workspace> take_workspace(
      const sightline::MapWindow& window) const;
  void give_back(std::unique_ptr<sightline::Workspace> workspace) const;

  sightline::VehicleMap map;      // its NDs are below
  std::vector<sightline_nd> nds;  // of a map that is held whole
  std::unique_ptr<sightline::MapWindows> windows;
  std::string kernel;
  mutable std::mutex mutex;
  mutable std::vector<std::unique_ptr<sightline::Workspace>> free;
};

sightline_localizer::sightline_localizer(sightline::VehicleMap opened)
    : map(std::move(opened)), kernel(sightline::kernel_name(sightline::fastest_kernel())) {
  const sightline::WindowOptions options{
      .own = sightline::localizer_named(map.localizer, map.coarse_cells),
      .usual_range_m = map.longest_look_m,
      .mounting_m = map.sensor.T_vehicle_lidar.translation().norm()};
  nds.reserve(map.ndt.nds.size());
  for (const sightline::Nd& nd : map.ndt.nds) nds.push_back(sightline::c_nd(nd, map.ndt.frame));
  std::vector<sightline::Nd> all = std::exchange(map.ndt.nds, {});
  sightline::NdtMap whole = map.ndt;
  whole.nds = std::move(all);
  windows = map.tiles == nullptr
                ? std::make_unique<sightline::MapWindows>(std::move(whole), options)
                : std::make_unique<sightline::MapWindows>(*map.tiles, options);
}

std::unique_ptr<sightline::Workspace> sightline_localizer::take_workspace(
    const sightline::MapWindow& window) const {
  std::unique_ptr<sightline::Workspace> workspace;
  {
    const std::scoped_lock lock(mutex);
    if (!free.empty()) {
      workspace = std::move(free.back());
      free.pop_back();
    }
  }
  if (workspace == nullptr) {
    const sightline::LookMatching matching{window.own, window.samples, map.sensor, map.leaf_m,
                                           map.takes_every_return};
    return std::make_unique<sightline::Workspace>(sightline::Workspace{
        {}, sightline::LookMatcher(matching), {sightline::LookCutter(map.leaf_m), {}}, {}});
  }
  workspace->matcher.use(window.own, window.samples);
  return workspace;
}

void sightline_localizer::give_back(std::unique_ptr<sightline::Workspace> workspace) const {
  const std::scoped_lock lock(mutex);
  free.push_back(std::move(workspace));
}

namespace sightline {
namespace {

Result<VehicleMap> open_map(const char* path, const sightline_localizer_options& options) {
  VehicleMapOptions chosen;
  if (options.cell_m != 0.0) chosen.cell_m = options.cell_m;
  if (options.least_points != 0) chosen.min_points = options.least_points;
  if (options.azimuth_step_deg != 0.0) chosen.azimuth_step_deg = options.azimuth_step_deg;
  if (options.T_vehicle_sensor != nullptr) {
    chosen.T_vehicle_sensor = pose_of(options.T_vehicle_sensor);
  }
  chosen.threads = options.threads;
  chosen.is_whole = options.holds_whole_map != 0;
  return read_vehicle_map(path, chosen);
}

bool is_good(const sightline_points& scan) {
  return scan.count < (std::size_t{1} << 31) && (scan.count == 0 || scan.first != nullptr);
}

constexpr int kBadArgument = static_cast<int>(ErrorCode::kBadArgument);

GivenErrors given_errors(const sightline_match_options* o) {
  if (o == nullptr) return {};
  return {o->start_covariance, o->variance_factor, o->map_m, o->map_rad, o->protection_risk};
}

// What is known of the start, if anything is.
std::optional<KnownStart> start_of(const MatchKnowledge& knowledge, const Pose& T_map_start) {
  if (!knowledge.start_covariance) return std::nullopt;
  return KnownStart{T_map_start, *knowledge.start_covariance};
}

// A pose has six degrees of freedom.
bool is_unconstrained(const MatchResult& found, const MatchEnd& end) {
  constexpr std::uint32_t kFewestPoints = 6;
  return found.stop == MatchStop::kConverged &&
         (found.scored_points < kFewestPoints || !end.holds_every_motion);
}

// What the calls share.
struct MatchCall {
  const sightline_localizer& localizer;
  double range_m;  // of the longest look
  const sightline_points& scan;
  const double* T_world_start;
  const sightline_match_options* options;
  sightline_match& answer;
};

// A match, and the scan that was matched, in the workspace.
struct MatchOfScan {
  MatchResult match;
  const ScanForMatch& scan;
};

// Where a match of the workspace's scan begins, and how far it looks for another optimum.
struct MatchBegin {
  Pose T_map_start = Pose::Identity();
  double search_m = std::numeric_limits<double>::infinity();
};

// Checks the other arguments and fills the answer. `use` matches the workspace's scan.
template <class Use>
int match_scan(const MatchCall& call, const Use& use) {
  const auto& [localizer, range_m, scan, T_world_start, options, answer] = call;
  const MapFrame& frame = localizer.map.ndt.frame;
  const Pose T_world_given = pose_of(T_world_start);
  if (!is_rigid(T_world_given) || !is_good(scan)) return kBadArgument;
  const Pose T_map_start = rebase(T_world_given, MapFrame{}, frame);
  const double away_m = T_map_start.translation().cwiseAbs().maxCoeff();
  if (!(away_m < kMostCells * localizer.map.ndt.cell_m)) return kBadArgument;
  const std::optional<MatchKnowledge> knowledge =
      knowledge_of(given_errors(options), kind_at(localizer.map, T_map_start));
  if (!knowledge) return kBadArgument;
  try {
    const std::shared_ptr<const MapWindow> window =
        localizer.windows->at(T_map_start.translation(), range_m);
    std::unique_ptr<Workspace> workspace = localizer.take_workspace(*window);
    std::vector<Eigen::Vector3d>& points_m = workspace->scan.points_m;
    take_returns({scan.first, scan.count, scan.stride_bytes, scan.is_double != 0}, points_m);
    answer.dropped_count = static_cast<std::uint32_t>(scan.count - points_m.size());
    const std::optional<KnownStart> start = start_of(*knowledge, T_map_start);
    MatchBegin begin{.T_map_start = T_map_start};
    if (start) begin.search_m = search_of_start_m(start->covariance);
    const MatchOfScan found = use(*window, *workspace, begin, answer);
    answer.point_count = static_cast<std::uint32_t>(found.scan.points_m.size());
    put(found.match, answer);
    const MatchEnd end = end_of_match(found.match, found.scan, start ? &*start : nullptr,
                                      window->structures, knowledge->scale, workspace->observer);
    put(end, frame, answer);
    if (is_unconstrained(found.match, end)) answer.stop = SIGHTLINE_UNCONSTRAINED;
    put_protection(*knowledge, found.match, end, answer);
    localizer.give_back(std::move(workspace));
    return 0;
  } catch (const std::bad_alloc&) {
    put_start(T_world_start, answer);
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

}  // namespace
}  // namespace sightline

using namespace sightline;

extern "C" {

int sightline_localizer_open(const char* path, const sightline_localizer_options* options,
                             sightline_localizer** localizer, char* message,
                             std::size_t message_size) {
  copy_message("", message, message_size);
  if (localizer != nullptr) *localizer = nullptr;
  if (localizer == nullptr || path == nullptr) {
    copy_message("no path, or no place for the localizer (NULL)", message, message_size);
    return kBadArgument;
  }
  try {
    Result<VehicleMap> map =
        open_map(path, options == nullptr ? sightline_localizer_options{} : *options);
    if (map) {
      auto opened = std::make_unique<sightline_localizer>(*std::move(map));
      if (options == nullptr || options->has_no_thread == 0) opened->windows->start_thread();
      *localizer = opened.release();
      return 0;
    }
    copy_message(to_string(map.error()), message, message_size);
    return static_cast<int>(map.error().code);
  } catch (const std::bad_alloc&) {
    copy_message("out of memory", message, message_size);
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

void sightline_localizer_close(sightline_localizer* localizer) { delete localizer; }

void sightline_localizer_get_info(const sightline_localizer* localizer,
                                  sightline_localizer_info* info) {
  if (info == nullptr) return;
  *info = {};
  info->localizer = info->kernel = "";
  if (localizer == nullptr) return;
  const VehicleMap& map = localizer->map;
  Eigen::Map<Eigen::Vector3d>(info->origin_world_m) = map.ndt.frame.origin_world_m;
  info->cell_m = map.ndt.cell_m;
  put_pose(map.sensor.T_vehicle_lidar, info->T_vehicle_sensor);
  info->leaf_m = map.leaf_m;
  info->localizer = map.localizer.c_str();
  info->kernel = localizer->kernel.c_str();
  info->nds = localizer->nds.data();
  info->nd_count = localizer->nds.size();
}

int sightline_localizer_match(const sightline_localizer* localizer, const sightline_points* scan,
                              const double T_world_start[12], const sightline_look* look,
                              const sightline_match_options* options, sightline_match* match) {
  if (match == nullptr) return kBadArgument;
  put_start(T_world_start, *match);
  if (localizer == nullptr || scan == nullptr || T_world_start == nullptr || look == nullptr) {
    return kBadArgument;
  }
  const Look chosen = look_of(*look);
  if (!validate(chosen)) return kBadArgument;
  return match_scan({*localizer, chosen.range_m, *scan, T_world_start, options, *match},
                    [&](const MapWindow& /*window*/, Workspace& workspace, const MatchBegin& begin,
                        sightline_match& answer) -> MatchOfScan {
                      workspace.matcher.take(workspace.scan, chosen);
                      answer.look_count = 1;
                      const MatchResult found =
                          workspace.matcher.match(begin.T_map_start, begin.search_m);
                      return {found, workspace.matcher.scan()};
                    });
}

int sightline_localizer_match_plan(const sightline_localizer* localizer,
                                   const sightline_points* scan, const double T_world_start[12],
                                   const sightline_look_plan* plan,
                                   const sightline_match_options* options, sightline_match* match) {
  if (plan == nullptr || plan->has_second == 0) {
    return sightline_localizer_match(localizer, scan, T_world_start,
                                     plan == nullptr ? nullptr : &plan->first, options, match);
  }
  if (match == nullptr) return kBadArgument;
  put_start(T_world_start, *match);
  if (localizer == nullptr || scan == nullptr || T_world_start == nullptr) return kBadArgument;
  const LookPlan chosen = plan_of(*plan);
  if (!validate(chosen)) return kBadArgument;
  const double range_m = std::max(chosen.first.range_m, chosen.second.range_m);
  return match_scan({*localizer, range_m, *scan, T_world_start, options, *match},
                    [&](const MapWindow& window, Workspace& workspace, const MatchBegin& begin,
                        sightline_match& answer) -> MatchOfScan {
                      PlannedLocalizer planned{window.samples, localizer->map.sensor, chosen};
                      planned.options.search_m = begin.search_m;
                      const PlannedMatch found = localize_in_looks(
                          planned, workspace.scan, {begin.T_map_start, true}, workspace.planned);
                      answer.look_count = found.look_count;
                      return {found.match, workspace.planned.cut};
                    });
}

int sightline_localizer_prepare(const sightline_localizer* localizer,
                                const double position_world_m[3], double budget_ms, int* is_done) {
  if (is_done != nullptr) *is_done = 0;
  if (localizer == nullptr || position_world_m == nullptr) return kBadArgument;
  const NdtMap& ndt = localizer->map.ndt;
  const Eigen::Vector3d p_map_m =
      Eigen::Map<const Eigen::Vector3d>(position_world_m) - ndt.frame.origin_world_m;
  if (!(p_map_m.cwiseAbs().maxCoeff() < kMostCells * ndt.cell_m)) return kBadArgument;
  try {
    const bool is_all = localizer->windows->prepare(p_map_m, budget_ms);
    if (is_done != nullptr) *is_done = is_all ? 1 : 0;
    return 0;
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

size_t sightline_localizer_fault_count(const sightline_localizer* localizer) {
  return localizer == nullptr ? 0 : localizer->windows->fault_count();
}

int sightline_localizer_get_fault(const sightline_localizer* localizer, std::size_t number,
                                  char* message, std::size_t message_size) {
  copy_message("", message, message_size);
  if (localizer == nullptr) return kBadArgument;
  if (number >= localizer->windows->fault_count()) return kBadArgument;
  try {
    const Error fault = localizer->windows->fault(number);
    copy_message(to_string(fault), message, message_size);
    return static_cast<int>(fault.code);
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

const char* sightline_localizer_version(void) {
  static const std::string kVersion = program_version();
  return kVersion.c_str();
}

}  // extern "C"
